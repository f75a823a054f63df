"""What gives way between the tip and what moves it: a frame or cantilever, and the tip itself."""
import numpy
import pytest

import harness
from ranks import SAME, expect_same
from tips import block

BALL = {**block(8), "indenter": "sphere", "indenter_radius": 80}
FRAME, TIP = {"indenter_stiffness": 10}, {"indenter_youngs_modulus": 5, "indenter_poissons_ratio": 0.2}


def at_rest(history):
    """Means over the hold at the largest depth: tip's depth, measured depth, load, radius of the contact, energy of what gives way."""
    moved = history["measured_depth"] if "measured_depth" in history else history["depth"]
    rest = moved > moved.max() * (1 - 1e-6)
    names = ("depth", "measured_depth", "load", "contact_half_width", "spring_energy")
    return [float(numpy.mean(history[name][rest])) for name in names]


def compliance(radius, options):
    ratio = options.get("indenter_poissons_ratio", 0)
    return 1 / options.get("indenter_stiffness", numpy.inf) + (1 - ratio**2) / (2 * radius * options.get("indenter_youngs_modulus", numpy.inf))


@pytest.mark.parametrize("options", [FRAME, TIP, {**FRAME, **TIP}], ids=("frame", "tip", "both"))
def test_ball(expect, options):
    """Depth by the frame, and by the load. The tip comes as deep as a rigid one under the same load. Seen: 1e-5, tip 2e-4, load .5 %."""
    rigid = harness.run_once({**BALL, "indenter_depths": "0.8"}).history
    depth, measured, load, radius, energy = at_rest(harness.run({**BALL, **options, "indenter_depths": "0.8"}).history)
    expect("measured depth, of that given", measured / 0.8, near=1, tolerance=1e-9)
    expect("what gives way, of the load times the compliance", (measured - depth) / (load * compliance(radius, options)), near=1, tolerance=2e-3)
    expect("load, of a rigid tip's at the same depth", load / numpy.interp(depth, rigid["depth"], rigid["load_quasi_static"]), near=1, tolerance=0.01)
    expect("energy, of that of a spring", energy / (0.5 * load * (measured - depth)), near=1, tolerance=2e-3)


def test_by_load(expect):
    """Nothing but the measured depth changes."""
    by_load = {**BALL, "indenter_control": "load", "indenter_times": "0,1", "indenter_loads": "0,8"}
    rigid, sprung = (harness.run({**by_load, **options}).history for options in ({}, {**FRAME, **TIP}))
    last = slice(-20, None)
    expect.that("depths are the same digits", numpy.array_equal(rigid["depth"], sprung["depth"]))
    stretch = (sprung["measured_depth"] - sprung["depth"])[last]
    expect("what gives way, of the load times the compliance", numpy.mean(stretch / (8 * compliance(sprung["contact_half_width"][last], {**FRAME, **TIP}))), near=1,
           tolerance=2e-3)


def test_half_of_an_indenter(expect):
    """The stiffness is that of the whole frame, whatever part of the indenter is simulated. Seen: 1e-4."""
    wedge = {"domain_lower": "-16,0", "domain_upper": "16,18", "cell_size": 1, "boundary_y_lower": "symmetry", "materials": "m", "m_youngs_modulus": 1,
             "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "b", "b_lower": "-16,0", "b_upper": "16,16", "indenter": "wedge", "indenter_half_angle": 70,
             "indenter_tip": "0,16", "indenter_stiffness": 2, "quasi_static": "true", "quasi_static_tolerance": 0.1, "indenter_depths": 1, "frames": 0}
    whole = harness.run(wedge).history
    half = harness.run({**wedge, "domain_lower": "0,0", "b_lower": "0,0", "boundary_x_lower": "symmetry"}).history
    expect("depth of a half indenter, of a whole one's", half["depth"][-1] / whole["depth"][-1], near=1, tolerance=1e-3)
    expect("its load, of half of the whole", 2 * half["load"][-1] / whole["load"][-1], near=1, tolerance=1e-3)


SHORT = {**BALL, **FRAME, **TIP, "indenter_depths": "0.8,0", "max_steps": 400, "frames": 1}


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks(expect, ranks):
    expect_same(expect, f"ball on {ranks} ranks", harness.run(SHORT, ranks=ranks), harness.run_once(SHORT), SAME)


def test_restart(expect, tmp_path):
    """A run goes on as if it had not stopped."""
    whole = harness.run_once(SHORT).history
    harness.run({**SHORT, "max_steps": 203, "checkpoint_interval": 200}, folder=tmp_path / "first")
    rest = harness.run({**SHORT, "restart": tmp_path / "first" / "checkpoint_000200.h5"}).history
    same = numpy.isin(whole["step"], rest["step"])
    for column in ("depth", "measured_depth", "load", "spring_energy"):
        expect.that(f"{column}: the same digits", numpy.array_equal(rest[column], whole[column][same]))
