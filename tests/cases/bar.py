"""A bar between rollers, held at one end and loaded by a ramped traction at the other: waves, and the static stress."""
import numpy
import pytest

import analytic
import harness
import studies_page as page
from mlgimp import results

E, NU, RHO = 100e9, 0.25, 2500
MODULUS = analytic.confined_modulus(E, NU)
SPEED = numpy.sqrt(MODULUS / RHO)  # of waves, m/s
LENGTH, CELL = 0.98, 0.02          # m; the end lies on a node of the undeformed grid but moves off it
PARTS = 40                         # frames of a run


def bar(pressure, rise_time, end_time, **others):
    """Options of a bar of four rows of cells under a pressure that rises to its peak within the rise time."""
    return {
        "domain_lower": "0,0", "domain_upper": [LENGTH + 6 * CELL, 4 * CELL], "cell_size": CELL, "boundary_x_lower": "symmetry",
        "boundary_y_lower": "symmetry", "boundary_y_upper": "symmetry", "materials": "glass", "glass_youngs_modulus": E,
        "glass_poissons_ratio": NU, "glass_density": RHO, "bodies": "glass", "glass_lower": "0,0",
        "glass_upper": [LENGTH, 4 * CELL], "loads": "end", "end_body": "glass", "end_side": "x_upper",
        "end_times": [0.0, rise_time], "end_pressures": [0.0, pressure], "end_time": end_time, **others,
    }


def frames(result):
    """(time, points ordered by id) of every frame."""
    for path in results.numbered_frames(result.folder).values():
        frame = results.read_frame(path)
        points = results.all_points(frame.levels)
        order = numpy.argsort(points["id"])
        yield frame.time, {name: values[order] for name, values in points.items()}


RISE_TIME, PULL = 50 * CELL / SPEED, 1e-5 * E  # of the traction in the study of waves


def end_motion(ranks):
    """(time, displacement of all points, their undeformed x, stress_xx, mask of the end's) of each frame, waves for two transits."""
    X = None
    for time, points in frames(harness.run(bar(PULL, RISE_TIME, 4 * LENGTH / SPEED, frames=PARTS), ranks=ranks)):
        if X is None:  # the first frame is early: the end has moved by less than a hundredth of a cell
            columns = CELL * 0.25 + 0.5 * CELL * numpy.arange(round(2 * LENGTH / CELL))
            X = columns[numpy.argmin(numpy.abs(points["position"][:, :1] - columns), axis=1)]
        yield time, points["position"][:, 0] - X, X, points["stress"][:, 0], X == columns[-1]


def exact_bar():
    return analytic.RampedBar(LENGTH, SPEED, MODULUS, -PULL, RISE_TIME)


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_waves(expect, ranks):
    """Two transits of the wave there and back, against d'Alembert, at a strain of 1e-5 where linear theory is good to 1e-5.

    Seen: 0.0013, 0.016, of first order: 0.0005, 0.0073 on cells of a half."""
    exact, peak = exact_bar(), 2 * PULL / MODULUS * LENGTH
    error = stress_error = reached = 0
    for time, u, X, stress, last in end_motion(ranks):
        error = max(error, numpy.max(numpy.abs(u - exact.displacement(X, time))[last]) / peak)
        reached = max(reached, numpy.max(numpy.abs(u[last])) / peak)
        stress_error = max(stress_error, numpy.max(numpy.abs(stress[last] - exact.stress(X[last], time))) / PULL)
    expect(f"bar, {ranks} ranks: end displacement, of the peak", error, at_most=0.01)
    expect(f"bar, {ranks} ranks: the end has moved, of the peak", reached, at_least=0.5)
    expect(f"bar, {ranks} ranks: stress of the last points, of the traction", stress_error, at_most=0.02)


def hold(pressure, law="neo_hookean", transits=20, **others):
    """Points of a damped bar after it was held under a pressure for a time."""
    options = bar(pressure, 4 * LENGTH / SPEED, transits * LENGTH / SPEED, frames=1, damping=numpy.pi * SPEED / LENGTH,
                  glass_model=law, history_interval=100, **others)
    return harness.run(options).frame()


PULLED = [(1e-4, 1e-4, "neo_hookean"), (0.05, 0.01, "neo_hookean"), (-0.05, 0.01, "neo_hookean"),
          (0.05, 0.01, "st_venant_kirchhoff")]


@pytest.mark.parametrize("part, limit, law", PULLED)
def test_static_stress(expect, part, limit, law):
    """In equilibrium the Cauchy stress is the traction on the current face, at any strain; damping takes the waves away.

    Seen: 5e-5 at 1e-4, alike on cells of a half; 0.0016 at the end and 0.0067 of all at 5 %, 0.0013 on cells of a half."""
    pressure = part * E
    points = hold(pressure, law)
    last = points["position"][:, 0] > points["position"][:, 0].max() - 0.1 * CELL
    error = numpy.abs(points["stress"][:, 0] / -pressure - 1)
    name = f"static bar, {law}, p/E = {part:g}"
    expect(f"{name}: stress of the last points against the traction", numpy.max(error[last]), at_most=limit)
    expect(f"{name}: stress of all points against the traction", numpy.max(error), at_most=limit)
    # The stretch follows from the law: sigma_xx = (mu/F)(F^2 - 1) + lambda ln F/F = -p, or F (lambda + 2 mu)(F^2 - 1)/2.
    F, (lam, mu) = points["deformation_gradient"][last, 0], analytic.lame_constants(E, NU)
    law_stress = mu / F * (F**2 - 1) + lam * numpy.log(F) / F if law == "neo_hookean" else 0.5 * F * MODULUS * (F**2 - 1)
    expect(f"{name}: stretch of the last points", numpy.max(numpy.abs(law_stress / -pressure - 1)), at_most=limit)


def stress_error(viscosity, transits):
    """Largest error of the stress in a bar that was held in tension, p/E = -0.05, of the traction."""
    points = hold(-0.05 * E, transits=transits, short_wave_viscosity=viscosity)
    return numpy.max(numpy.abs(points["stress"][:, 0] / (0.05 * E) - 1))


def test_long_hold_in_tension(expect):
    """Without any viscosity: points once moved with another velocity than strained them, and stresses were wrong by half. Seen: 0.0034."""
    expect("bar held for 60 transits: stress of all points against the traction", stress_error("0,0", 60), at_most=0.01)


def verify_waves(study):
    """Waves in a bar

    A traction on its end rises over half of a transit to a strain of 1e-5; two transits there and back, against d'Alembert.
    """
    for ranks in (1, 2):
        test_waves(study.expect, ranks)
    exact, static = exact_bar(), -PULL / MODULUS * LENGTH
    motion = [(time, u[last].mean(), X[last].mean()) for time, u, X, _, last in end_motion(1)]
    times, ends, places = map(numpy.array, zip(*motion))
    shown = numpy.linspace(0, times[-1], 200)
    transit = LENGTH / SPEED
    study.plot("Displacement of the end", "time (transits of the wave)", "displacement / static displacement",
                page.curve("exact", shown / transit, exact.displacement(places[0], shown) / static, "reference"),
                page.curve("points", times / transit, ends / static, "dots"))


def verify_static_stress(study):
    """Stress of a bar at rest, and how long it stays

    In equilibrium the Cauchy stress is the traction on the current face. The table has bars in tension, p/E = -0.05, with and
    without the short-wave viscosity: noise would grow in them if points moved with another velocity than strains them.
    """
    for pulled in PULLED:
        test_static_stress(study.expect, *pulled)
    cells = []
    for viscosity in ("0,0", "0.001,0", "0.001,8"):
        cells.append([viscosity, *(f"{100 * stress_error(viscosity, transits):.2g} %" for transits in (20, 60, 200))])
    study.table("Largest stress error of a bar held at p/E = -0.05", ["a,b", "20 transits", "60 transits", "200 transits"], cells)
