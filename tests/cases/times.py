"""Times that waves do not agree with make warnings: loadings of a few transits, runs without end, rates in another unit."""
import subprocess
import tempfile

import pytest

import harness
from limits import BLOCK, FAST, PRESS, WARNING, warnings

CYLINDER = {**PRESS, "indenter": "cylinder", "indenter_radius": 10, "boundary_x_lower": "symmetry", "indenter_tip": "0,8"}
TRANSIT = 8 / (1e9 * 0.7 / (1.3 * 0.4) / 1000) ** 0.5  # s, from the tip to the support
BY_LOAD = {name: value for name, value in CYLINDER.items() if name not in ("indenter_velocities", "indenter_max_depth")} | {
    "indenter_control": "load"}


def paces(options):
    """The warnings of loadings that are too fast."""
    return [line for line in warnings(options, but=()) if FAST in line]


@pytest.mark.parametrize("transits, warned", [(0.6, True), (1.9, True), (2.1, False), (10, False)])
def test_loading_of_few_transits(transits, warned):
    """Of 0.6 the load is 1.3 times that of a slow test. The way to the body does not count."""
    case = {**CYLINDER, "indenter_tip": "0,8.5", "indenter_max_depth": 0.2, "indenter_velocities": 0.2 / (transits * TRANSIT)}
    assert len(paces(case)) == warned


@pytest.mark.parametrize("times, loads, warned", [
    ((0, 3, 20), (0, 1e7, 1e7), "rise within"), ((0, 6, 20), (0, 1e7, 1e7), ""), ((0, 20), (1e7, 1e7), "begin at once"),
    ((0, 10, 13, 20), (0, 5e6, 1e7, 0), ""), ((0, 10, 11, 20), (0, 5e6, 1e7, 0), "rise within")])
def test_loads_that_rise_fast(times, loads, warned):
    """The tip overshoots: by 29 % in depth where the load comes within a third of a transit, by 45 % for good in a metal."""
    case = {**BY_LOAD, "indenter_times": ",".join(str(time * TRANSIT) for time in times), "indenter_loads": ",".join(map(str, loads)),
            "end_time": 20 * TRANSIT}
    said = paces(case)
    assert [warned in line for line in said] == [True] * bool(warned), said


def test_time_of_a_laboratory_gives_a_warning():
    """Some 3e9 steps; the line comes before them."""
    words = harness.to_arguments({**BY_LOAD, "indenter_times": "0,1e6", "indenter_loads": "0,1e7", "end_time": 1e6,
                                  "output_dir": tempfile.mkdtemp(dir=harness.scratch()), "overwrite": None, "monitor": "false"})
    with subprocess.Popen(harness.command(words, 1), stderr=subprocess.PIPE, text=True, env=harness.environment(1)) as run:
        line = run.stderr.readline()
        run.kill()
    assert line.startswith(WARNING + "-end_time: the end of the run at 1e+06 s is some 2.9") and "e+09 steps of " in line and line.endswith("slow test\n"), line


METAL = {"al_model": "j2", "al_hardening": "johnson_cook", "al_yield_stress": 1e7, "al_hardening_modulus": 1e7, "al_hardening_exponent": 0.5,
         "al_rate_sensitivity": 0.01, "al_reference_rate": 1, "al_thermal_exponent": 1, "al_melting_temperature": 1000}


@pytest.mark.parametrize("rate, warned", [(1, False), (1e-4, False), (1e-6, True)])
def test_reference_rate_in_another_unit(rate, warned):
    """1/us for 1/s made a metal 40 % too hard."""
    said = warnings({**CYLINDER, **METAL, "al_reference_rate": rate, "rate_scale": 1e-3, "max_steps": 1})
    assert [line for line in said if "rate " in line] == [WARNING + "-al_reference_rate 1e-06: is slower than tests are; is it in 1/s?"] * warned


@pytest.mark.parametrize("times, shares, law, warned", [
    ((0,), (0.8,), "j2", True), ((0,), (-0.8,), "j2", True), ((0,), (0.45,), "j2", False), ((0,), (1.1,), "j2", False),
    ((0,), (0.8,), "neo_hookean", False), ((0, 1e-3), (0, 0.8), "j2", True), ((0, 1), (0, 0.8), "j2", True), ((0, 10), (0, 0.8), "j2", False),
    ((0, 10, 10.1), (0, 0.4, 0.8), "j2", True), ((0, 10, 10.1), (0, 0.8, 0.75), "j2", False)])
def test_pressures_that_strike_a_metal_give_a_warning(times, shares, law, warned):
    """At once, or within a transit, 0.8 of the yield stress left a strain of 0.005 for good; times in transits."""
    metal = {"al_model": law, "al_yield_stress": 1e7, "al_hardening_modulus": 1e7} if law == "j2" else {}
    said = warnings({**BLOCK, **metal, "boundary_y_lower": "symmetry", "loads": "p", "p_side": "y_upper", "p_times": [time * TRANSIT for time in times],
                     "p_pressures": [share * 1e7 for share in shares], "end_time": 1, "max_steps": 1})
    assert any("-p_pressures: change by so much within" in line and "the stress of the wave" in line for line in said) == warned, said


@pytest.mark.parametrize("pressure, warned", [(10, True), (1e4, False), (0, False)])
def test_pressures_in_another_unit_give_a_warning(pressure, warned):
    """10 for 10 MPa on a body of 1 GPa is none."""
    said = warnings({**BLOCK, "boundary_y_lower": "symmetry", "loads": "p", "p_side": "y_upper", "p_times": 0, "p_pressures": pressure,
                     "end_time": 1, "max_steps": 1})
    assert any("-p_pressures: a pressure of at most 10 Pa" in line and "are they in Pa?" in line for line in said) == warned, said


def test_slow_schedules_tell_the_time_of_their_test():
    """The tolerance chooses the length of the run, and -rate_scale with it the rate of a test."""
    slow = {name: value for name, value in CYLINDER.items() if name not in ("indenter_times", "indenter_velocities", "indenter_max_depth")}
    words = harness.to_arguments({**slow, **METAL, "rate_scale": 1e-3, "quasi_static": "true", "indenter_depths": 0.2, "max_steps": 1,
                                  "output_dir": tempfile.mkdtemp(dir=harness.scratch()), "overwrite": None, "monitor": "false"})
    done = subprocess.run(harness.command(words, 1), capture_output=True, text=True, env=harness.environment(1), timeout=60)
    words = done.stdout.split()
    place = words.index("schedule")
    length, test = float(words[place + 2]), float(words[words.index("test") + 2])
    assert words[place + 3] == "s," and abs(test / (1000 * length) - 1) < 1e-3, done.stdout
