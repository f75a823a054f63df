"""The paper's one-level cases against finite elements (CalculiX, tests/reference), with the same elastic law."""
import numpy
import pytest

import harness
import studies_page as page
from harness import run

REFERENCE = harness.ROOT / "tests" / "reference"


def columns(name, **where):
    """Columns of a reference CSV, the rows where the named columns have the given values."""
    table = {key: numpy.array(values) for key, values in harness.read_csv(REFERENCE / name).items()}
    keep = numpy.ones(len(next(iter(table.values()))), bool)
    for key, value in where.items():
        keep &= abs(table[key] - value) <= 1e-6 * abs(value)
    return {key: values[keep] for key, values in table.items()}


def start_of(options, file):
    """Points at the start, by a run of one step."""
    return run({**options, "max_steps": 1, "frames": 1}, file=file).frame()


def tension(peak, options=None):
    """Frames of the tension case at its middle and end, and its undeformed points."""
    options = {"silicon_model": "st_venant_kirchhoff", "pull_pressures": [0, -peak], "frames": 2, **(options or {})}
    return run(options, file="tension.opts"), start_of(options, "tension.opts")


def compare_tension(expect, peak, options=None):
    """Notes the differences; returns curves of the stress along the middle."""
    result, start = tension(peak, options)
    curves = []
    last = start["position"][:, 0] > start["position"][:, 0].max() - 1e-9
    scale = peak
    for number, time in ((1, 12.5e-9), (2, 25e-9)):
        frame = result.frame(number)
        reference = columns("tension.csv", peak_Pa=peak, time_s=time)["ux_mean_m"][0]
        end = (frame["position"][last, 0] + frame["half_size"][last, 0]).mean() - 60e-6
        expect(f"tension {peak / 1e9:g} GPa, {time * 1e9:g} ns: end displacement, relative error",
               abs(end / reference - 1), at_most=0.01)
        profile = columns("tension_profile.csv", peak_Pa=peak, time_s=time)
        scale = max(scale, abs(profile["stress_xx_Pa"]).max())
        middle = abs(start["position"][:, 1] - 20e-6) < 0.6e-6
        expected = numpy.interp(start["position"][middle, 0], profile["x_m"], profile["stress_xx_Pa"])
        error = abs(frame["stress"][middle, 0] - expected).max() / scale
        expect(f"tension {peak / 1e9:g} GPa, {time * 1e9:g} ns: stress on the midline, error over peak", error,
               at_most=0.03)
        along = numpy.argsort(start["position"][middle, 0])
        curves += [(f"{time * 1e9:g} ns", start["position"][middle, 0][along], frame["stress"][middle, 0][along], "line"),
                   ("_" if number > 1 else "FEM", profile["x_m"], profile["stress_xx_Pa"], "reference")]
    return curves


@pytest.mark.parametrize("peak", [1e9, 8e9])
def test_tension(expect, peak):
    compare_tension(expect, peak)


def test_original_mpm_tears(expect):
    """With hat functions at the points' centres the stress of the same case is noise (the paper's Fig. 9a)."""
    from_mean = {}
    for shape in ("linear", "cpgimp"):
        result = run({"shape_function": shape, "frames": 1}, file="tension.opts")
        stress = result.frame()["stress"][:, 0]
        from_mean[shape] = stress.std() / abs(stress.mean())
    expect("tension: scatter of the stress, original MPM over cpGIMP", from_mean["linear"] / from_mean["cpgimp"],
           at_least=3)


def pressure(peak, times, cell):
    """The pressure case up to the last time, a frame at each of the equally spaced times, and its undeformed points."""
    options = {"silicon_model": "st_venant_kirchhoff", "press_pressures": [0, peak], "cell_size": cell,
               "time_step": 20e-12 * cell / 1e-6, "max_steps": 0, "end_time": times[-1], "frames": len(times)}
    return run(options, file="pressure.opts"), start_of(options, "pressure.opts")


def compare_pressure(expect, peak, times, cell=1e-6):
    """Notes the differences; returns curves of the stress along the axis."""
    curves = []
    result, start = pressure(peak, times, cell)
    history = columns("pressure.csv", peak_Pa=peak)
    axis = start["position"][:, 0] < 0.3 * cell
    heights = start["position"][axis, 1]
    top = numpy.argmax(heights)
    for number, time in enumerate(times, 1):
        frame = result.frame(number)
        position, size, stress = frame["position"][axis], frame["half_size"][axis], frame["stress"][axis, 1]
        displacement = position[top, 1] + size[top, 1] - 40e-6
        name = f"pressure {peak / 1e9:g} GPa, {time * 1e9:g} ns, cells of {cell * 1e6:g} um: "
        expected = numpy.interp(time, history["time_s"], history["uy_m"])
        expect(name + "displacement under the load, relative error", abs(displacement / expected - 1), at_most=0.02)
        profile = columns("pressure_axis.csv", peak_Pa=peak, time_s=time)
        order = numpy.argsort(profile["y_m"])
        expected = numpy.interp(heights, profile["y_m"][order], profile["stress_yy_Pa"][order])
        error = abs(stress - expected).max() / abs(expected).max()
        expect(name + "stress_yy on the axis, error over peak", error, at_most=0.03)
        along = numpy.argsort(heights)
        curves += [(f"{time * 1e9:g} ns", heights[along], stress[along], "line"),
                   ("_" if number > 1 else "FEM", profile["y_m"][order], profile["stress_yy_Pa"][order], "reference")]
    return curves


PRESSURES = [(6e9, [10e-9, 20e-9, 30e-9, 40e-9]), (60e9, [5e-9, 10e-9])]


@pytest.mark.parametrize("peak, times", PRESSURES)
def test_pressure(expect, peak, times):
    compare_pressure(expect, peak, times)


def wedge_reference(depths):
    """The converged load: the finest mesh that got to each depth, extrapolated to zero size from the last two."""
    table = columns("wedge.csv")
    return numpy.interp(depths, table["depth_m"], table["load_h62nm_N"])


def compare_wedge(expect, result, limits):
    history = result.history
    for depth, limit in limits.items():
        load = numpy.interp(depth * 1e-9, history["depth"], history["load"])
        expect(f"wedge: load at {depth} nm against finite elements, relative error",
               abs(load / wedge_reference(depth * 1e-9) - 1), at_most=limit)


def plot_stress(study, title, xlabel, component, curves):
    study.plot(title, xlabel, f"stress_{component} (GPa)",
                *(page.curve(label, 1e6 * place, 1e-9 * stress, kind) for label, place, stress, kind in curves))


def verify_tension(study):
    """Tension against finite elements

    Silicon pulled to 1 and 8 GPa (the paper's Fig. 9), St. Venant-Kirchhoff on both sides.
    """
    for peak in (1e9, 8e9):
        plot_stress(study, f"Tension to {peak / 1e9:g} GPa: stress along the middle", "undeformed x (µm)", "xx", compare_tension(study.expect, peak))
    test_original_mpm_tears(study.expect)


def verify_pressure(study):
    """Pressure on a block against finite elements

    Silicon pressed on its middle (the paper's Figs. 10, 11), St. Venant-Kirchhoff on both sides; at 60 GPa the finite
    elements stop after 18 ns, where the law loses its stiffness.
    """
    for peak, times in PRESSURES:
        plot_stress(study, f"Pressure to {peak / 1e9:g} GPa: stress on the axis", "undeformed y (µm)", "yy", compare_pressure(study.expect, peak, times))


def verify_wedge(study):
    """Wedge indentation against finite elements

    Aluminium, 450 nm deep at 20 m/s, cells of 125 nm, St. Venant-Kirchhoff on both sides. Until the first reflection is
    back, at 190 nm, the problem is similar to itself: the load is the depth times 8.53 kN/m (tests/reference).
    """
    result = run({"aluminium_model": "st_venant_kirchhoff", "history_interval": 2, "frames": 5}, file="wedge_125nm.opts", ranks=harness.up_to(2))
    compare_wedge(study.expect, result, {100: 0.06, 200: 0.03, 250: 0.03, 300: 0.03, 350: 0.03, 400: 0.03, 450: 0.03})
    history, depths = result.history, numpy.linspace(0, 450e-9, 100)
    study.plot("Load against depth, cells of 125 nm", "depth (nm)", "load (mN)",
                page.curve("points", 1e9 * history["depth"], 1e3 * history["load"]),
                page.curve("FEM", 1e9 * depths, 1e3 * wedge_reference(depths), "reference"),
                page.curve("8.53 kN/m, until the first reflection", [0, 190], [0, 8.53e3 * 190e-6], "guide"))
    plot_wedge_axis(study, result)


def plot_wedge_axis(study, result):
    """Stress at places below the surface that move with the material, at five depths of the wedge."""
    table = columns("wedge_axis.csv")
    finest = table["mesh_m"] == table["mesh_m"][table["depth_m"] > 449e-9].min()
    start = start_of({}, "wedge_125nm.opts")
    axis = start["position"][:, 0] < 1.05 * start["half_size"][:, 0]
    heights = start["position"][axis, 1]
    along, places = numpy.argsort(heights), (1, 2, 5, 10)
    curves = []
    for place in places:
        stress = [numpy.interp(40e-6 - place * 1e-6, heights[along], result.frame(number)["stress"][axis, 1][along]) for number in range(1, 6)]
        curves.append(page.curve(f"{place} µm below the surface", [90, 180, 270, 360, 450], 1e-9 * numpy.array(stress), "points"))
    for place in places:
        curves.append(page.curve("FEM" if place == 1 else "_", 1e9 * table["depth_m"][finest], 1e-9 * table[f"syy_{place}um_Pa"][finest], "reference"))
    study.plot("Stress on the axis", "depth (nm)", "stress_yy (GPa)", *curves)
