"""Input that no cell, step or number can resolve makes a warning of one line instead of a wrong answer in silence."""
import subprocess
import tempfile

import numpy
import pytest

import harness
from mlgimp.results import read_history

BLOCK = {"domain_lower": "0,0", "domain_upper": "12,12", "cell_size": 1, "materials": "al", "al_youngs_modulus": 1e9,
         "al_poissons_ratio": 0.3, "al_density": 1000, "bodies": "block", "block_lower": "0,0", "block_upper": "8,8", "frames": 0}
PRESS = {**BLOCK, "indenter_tip": "4,8", "indenter_times": 0, "indenter_velocities": 50, "indenter_max_depth": 1,
         "boundary_y_lower": "symmetry"}
WARNING, FEW_CELLS, FAST = "mlgimp: warning: ", "half the contact's width is at most ", " s through the bodies: "
ON_RANKS = [1, pytest.param(3, marks=pytest.mark.mpi)]


def end_of(options, ranks=1, timeout=60):
    """(exit status, lines on standard error, folder) of a run."""
    folder = tempfile.mkdtemp(dir=harness.scratch())
    words = harness.to_arguments({**options, "output_dir": folder, "overwrite": None, "monitor": "false"})
    done = subprocess.run(harness.command(words, ranks), capture_output=True, text=True, env=harness.environment(ranks), timeout=timeout)
    return done.returncode, harness.lines_of(done.stderr), folder


def refusal(options, ranks=1):
    """The one line that a run ends with."""
    status, lines, _ = end_of(options, ranks)
    assert status > 0 and len(lines) == 1 and lines[0].startswith("mlgimp: error: "), (status, lines)
    return lines[0]


def warnings(options, but=(FEW_CELLS, FAST)):
    """What a run says that goes to its end, but of few cells and fast loadings, which most here have."""
    status, lines, _ = end_of(options)
    assert status == 0 and all(line.startswith(WARNING) for line in lines), (status, lines)
    return [line for line in lines if not any(words in line for words in but)]


# ---- indenters that the surface cannot see ----

@pytest.mark.parametrize("friction,warned", [(30, True), (3.5, True), (3, False), ("inf", False)])
def test_friction_in_per_cent(friction, warned):
    """30 for a coefficient of 0.3 sticks everywhere, and looks like an answer."""
    said = warnings({**PRESS, "indenter": "wedge", "indenter_half_angle": 70, "indenter_max_depth": 0.2, "indenter_friction": friction})
    assert [line.startswith(WARNING + "-indenter_friction") for line in said] == [True] * warned


@pytest.mark.parametrize("change, warned", [
    ({"al_density": 1}, "-al_density 1: waves have 3.669e+04 m/s"), ({"al_density": 2}, None),
    ({"al_youngs_modulus": 1e6}, "-indenter: moves at up to 50 m/s, and waves at 36.69 m/s"), ({"al_youngs_modulus": 1e9}, None),
    ({"boundary_x_lower": "free"}, "-boundary_x_lower: the indenter's tip is on this side"), ({"boundary_x_lower": "fixed"}, "-boundary_x_lower")])
def test_other_units_and_a_forgotten_side_of_symmetry_give_a_warning(change, warned):
    """g/cm3 for kg/m3, MPa for Pa, and half of a body that was meant to be mirrored."""
    said = warnings({**PRESS, "indenter": "cylinder", "indenter_radius": 10, "indenter_tip": "0,8", "boundary_x_lower": "symmetry", "max_steps": 2,
                     **change})
    assert [line.startswith(WARNING + warned) for line in said] == [True] if warned else said == []


def test_speed_and_friction_have_a_line_each():
    """Where such a run is refused for something else there is none; see bad_input_of_contact.py."""
    case = {**PRESS, "indenter": "wedge", "indenter_half_angle": 70, "indenter_friction": 30, "indenter_velocities": 1e4}
    assert len(warnings({**case, "max_steps": 1})) == 2


def test_punch_as_wide_as_a_cell_of_its_level():
    levels = {"levels": 2, "level_1_lower": "0,2", "level_1_upper": "8,12", "domain_upper": "16,12"}
    case = {**PRESS, "indenter": "flat_punch", "indenter_width": 0.5, "indenter_max_depth": 0.05, "indenter_velocities": 20}
    assert warnings({**case, **levels}) == []


def test_wedge_narrower_than_a_cell_at_its_largest_depth():
    said = warnings({**PRESS, "indenter": "wedge", "indenter_half_angle": 45, "indenter_max_depth": 0.2})
    assert sum("-indenter wedge: at its largest depth of 0.2 m it is 0.4 m wide" in line for line in said) == 1


def test_wide_indenters_say_nothing():
    for indenter in ({"indenter": "wedge", "indenter_half_angle": 70}, {"indenter": "cylinder", "indenter_radius": 10}):
        assert warnings({**PRESS, **indenter, "indenter_velocities": 10}) == []


def test_indenters_in_another_unit():
    """A radius of 100 for 100 um is a plane as far as cells can see; a plane that is meant is a flat punch or a polygon."""
    curved = {**PRESS, "indenter": "cylinder", "max_steps": 2}
    assert warnings({**curved, "indenter_radius": 100}) == []
    assert [line.startswith(WARNING + "-indenter cylinder: rises by less than 0.1 cells") for line in warnings({**curved, "indenter_radius": 1e5})] == [True]
    assert warnings({**PRESS, "indenter": "flat_punch", "indenter_width": 100, "max_steps": 2}) == []
    assert warnings({**PRESS, "indenter": "polygon", "indenter_vertices": "-50,0,50,0,50,5,-50,5", "max_steps": 2}) == []


@pytest.mark.parametrize("change, warned", [
    ({}, False), ({"boundary_y_lower": "free"}, True), ({"block_lower": "0,1"}, True), ({"block_lower": "0,1", "boundary_x_lower": "symmetry"}, True),
    ({"block_lower": "0,1", "boundary_x_lower": "fixed"}, False), ({"boundary_y_lower": "free", "contact": "none"}, False)])
def test_bodies_that_nothing_holds_give_a_warning(change, warned):
    """Pushed away, they gave a load of 57 % without a word."""
    said = warnings({**PRESS, "indenter": "cylinder", "indenter_radius": 10, "max_steps": 2, **change})
    assert [line.startswith(WARNING + "-boundary_y_lower: no body lies at a side") for line in said] == [True] * warned


@pytest.mark.parametrize("change, word", [
    ({"gravity": "0,50"}, None), ({"loads": "push", "push_side": "y_lower", "push_times": 0, "push_pressures": 10}, None),
    ({"gravity": "0,-50"}, "-gravity 0,-50: no body lies at a side of the domain that holds it: they fall"),
    ({"gravity": "0,-50", "indenter_velocities": 50}, "-boundary_y_lower: no body lies at a side of the domain that holds it against the indenter")])
def test_bodies_that_a_punch_at_rest_holds(change, word):
    """What presses a body against the punch is held by that; where the weight pulls it away, nothing holds it."""
    case = {name: value for name, value in PRESS.items() if name != "indenter_max_depth"}
    said = warnings({**case, "indenter": "flat_punch", "indenter_width": 20, "indenter_velocities": 0, "boundary_y_lower": "free",
                     "max_steps": 2, **change})
    held = [line for line in said if "no body lies" in line]
    assert len(held) == (word is not None) and all(line.startswith(WARNING + word) for line in held), said


@pytest.mark.parametrize("damping, warned", [(1000, True), (10, False)])
def test_damping_that_carries_the_load_gives_a_warning(damping, warned):
    said = warnings({**PRESS, "indenter": "cylinder", "indenter_radius": 10, "damping": damping})
    assert [line.startswith(WARNING + f"-damping {damping}: has taken") for line in said] == [True] * warned


def test_largest_depth_after_the_end_gives_a_warning():
    case = {**PRESS, "indenter": "cylinder", "indenter_radius": 10, "indenter_max_depth": 0.2}
    assert warnings({**case, "end_time": 0.005}) == []
    said = warnings({**case, "end_time": 0.003, "indenter_unload_velocity": 50})
    assert len(said) == 1 and said[0].startswith(WARNING + "-end_time 0.003: comes before the tip reaches -indenter_max_depth 0.2, so that"), said


def test_surface_deep_inside_the_indenter_gives_a_warning():
    """A slender wedge goes between the columns: the surface is inside it, and the history and a line say so."""
    case = {**PRESS, "cell_size": 0.25, "domain_upper": "14,12", "block_lower": "1,0", "block_upper": "13,8", "indenter_tip": "7,8",
            "indenter": "wedge", "indenter_half_angle": 8, "indenter_velocities": 5, "indenter_max_depth": 2,
            "al_model": "j2", "al_yield_stress": 1e6, "al_hardening_modulus": 0}
    status, lines, folder = end_of(case)
    warned = [line for line in lines if line.startswith(WARNING + "-cell_size 0.25: the surface lies")]
    history = read_history(folder)
    assert (numpy.max(history["penetration"]) > 0.25) == (len(warned) == 1), lines


@pytest.mark.parametrize("half_angle, depth, warned", [(10, 5.5e-6, 1), (10, 3.2e-6, 0), (60, 0.8e-6, 0)])
def test_surface_torn_open_gives_a_warning(half_angle, depth, warned):
    """A slender wedge that goes some cells deep parts the points of a metal; the books of its work do not close: by 0.21, 0.07 and less than 0.01."""
    result = harness.run({"indenter_half_angle": half_angle, "indenter_max_depth": depth, "frames": 0}, file="wedge_plastic.opts")
    history = result.history
    excess = harness.given_by_contact(history)[-1] / history["indenter_work"][-1] - 1
    assert (excess > 0.1) == bool(warned), excess
    assert result.stderr.count(WARNING + "-indenter: contact has given") == warned, result.stderr


@pytest.mark.parametrize("upper, warned", [("4,12", True), ("8,12", False)])
@pytest.mark.parametrize("ranks", ON_RANKS)
def test_contact_across_a_border_of_levels_gives_a_warning(ranks, upper, warned):
    """Columns of both levels press the nodes there, and what each carries is no pressure: 2.5 times that of a plate."""
    plate = {**PRESS, "boundary_x_lower": "symmetry", "boundary_x_upper": "symmetry", "domain_upper": "8,12", "indenter": "flat_punch",
             "indenter_width": 20, "indenter_max_depth": 0.1, "levels": 2, "level_1_lower": "0,4", "level_1_upper": upper}
    result = harness.run({**plate, "indenter_tip": "0,8"}, ranks=ranks)
    crosses = [line for line in result.summary["warnings"] if line.startswith("-level_1_lower, -level_1_upper: contact crosses a border of levels by")]
    assert len(crosses) == warned, result.summary["warnings"]


def test_wedge_beside_the_free_edge_of_an_elastic_body(expect):
    """Its blows once gave the body more than a tenth more than the wedge's work."""
    edge = {**PRESS, "domain_upper": "20,20", "block_upper": "16,16", "boundary_x_lower": "symmetry", "indenter": "wedge", "indenter_half_angle": 45,
            "indenter_velocities": 5}
    history = harness.run({**edge, "indenter_tip": "15.5,16"}).history
    expect("work given over the indenter's", harness.given_by_contact(history)[-1] / history["indenter_work"][-1], near=1, tolerance=0.03)
    assert warnings({**edge, "indenter_tip": "0,16", "indenter_half_angle": 70, "indenter_max_depth": 0.3}) == []


def test_materials_of_no_body_have_no_effect():
    """Their names once chose XPIC, the width of the contact's kernels and the steps of all others."""
    wedge = {**PRESS, "indenter": "wedge", "indenter_half_angle": 70, "indenter_max_depth": 0.2}
    more = {"materials": "other,al", "block_material": "al", "other_model": "j2", "other_youngs_modulus": 1e11, "other_poissons_ratio": 0.3,
            "other_density": 1000, "other_yield_stress": 1e7, "other_hardening_modulus": 0}
    alone, beside = harness.run(wedge), harness.run({**wedge, **more})
    warned = [line for line in beside.summary["warnings"] if line not in alone.summary["warnings"]]
    assert warned == ["-materials other: no body has it, and it has no effect"], warned
    assert all(numpy.array_equal(alone.history[name], beside.history[name]) for name in alone.history)


# ---- steps ----

@pytest.mark.parametrize("cfl, warned", [(1, True), (0.4, False)])
def test_energy_from_nothing_gives_a_warning(cfl, warned):
    """A strong viscosity is not stable with the longest steps: two blows ended with 190 times the energy, without a word."""
    falling = {**BLOCK, "block_velocity": "0,-20", "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry", "short_wave_viscosity": "0.1,0", "max_steps": 200}
    status, lines, folder = end_of({**falling, "cfl": cfl})
    starts = ["-short_wave_viscosity 0.1,0: has given ", f"-cfl {cfl}: the bodies have made "] if warned else []
    assert status == 0 and [line[:len(WARNING + start)] for line, start in zip(lines, starts)] == [WARNING + start for start in starts], lines
    assert len(lines) == len(starts), lines
    energy = sum(read_history(folder)[part] for part in ("kinetic_energy", "strain_energy", "dissipated_energy"))
    for line in lines[1:]:
        made, had = (float(part.split()[-1]) for part in line.split(" J")[:2])
        assert made == pytest.approx(energy[-1] - energy[0], rel=1e-3) and had == pytest.approx(energy[0], rel=1e-3)


@pytest.mark.parametrize("damping", [7000, 1e5])
def test_damping_takes_energy(damping):
    """The nodal update takes damping explicitly: beyond 2/dt it once made energy without limit."""
    history = harness.run({**BLOCK, "damping": damping, "block_velocity": "1,0", "max_steps": 200}).history
    assert numpy.all(numpy.diff(history["kinetic_energy"]) <= 0)
    assert history["kinetic_energy"][0] == pytest.approx(history["dissipated_energy"][-1], rel=1e-6)


def test_damping_brings_gravity_to_rest():
    case = {**BLOCK, "damping": 6000, "gravity": "0,-10", "boundary_y_lower": "symmetry", "max_steps": 3000}
    history = harness.run(case).history
    assert history["kinetic_energy"][-1] < 0.1 * numpy.max(history["kinetic_energy"])  # it creeps
    assert numpy.all(numpy.diff(history["dissipated_energy"]) >= 0)


def test_indenter_faster_than_waves():
    """It once jumped through the body in one step; now it meets it cell by cell."""
    case = {**BLOCK, "indenter": "polygon", "indenter_tip": "4,9", "indenter_vertices": "0,0,3,1,0,2,-3,1", "indenter_times": 0,
            "indenter_velocities": 1e4, "indenter_max_depth": 1, "boundary_y_lower": "symmetry"}
    status, lines, folder = end_of(case)
    history = read_history(folder)
    assert numpy.max(numpy.diff(history["depth"])) <= 0.4 * (1 + 1e-9)
    assert numpy.max(history["load"]) > 0, lines


@pytest.mark.parametrize("change, warned", [
    ({"indenter_tip": "10,8"}, True), ({"indenter_tip": "40,8"}, True), ({"indenter_velocities": -50, "indenter_max_depth": None, "max_steps": 50}, True),
    ({}, False), ({"indenter_max_depth": 0.02}, False)])
def test_indenter_that_meets_nothing_gives_a_warning(change, warned):
    """Beside the body, beyond the domain, or with the wrong sign: a load of 0 looks like an answer."""
    case = {**PRESS, "indenter": "cylinder", "indenter_radius": 5, "indenter_max_depth": 0.2, "domain_upper": "16,12", **change}
    said = warnings({name: value for name, value in case.items() if value is not None})
    assert any("has touched nothing" in line for line in said) == warned, said


@pytest.mark.parametrize("height, warned", [(7.95, False), (8.5, True)])
def test_indenter_between_two_walls(height, warned):
    """Its tip comes nowhere near what is below it, but its flanks may meet the walls' edges."""
    walls = {"bodies": "block,left,right", "block_upper": "8,4", "left_lower": "0,4", "left_upper": "3,8", "right_lower": "5,4", "right_upper": "8,8"}
    press = {name: value for name, value in PRESS.items() if name != "indenter_max_depth"}
    said = warnings({**press, **walls, "indenter": "cylinder", "indenter_radius": 5, "indenter_tip": f"4,{height}", "end_time": 4e-3})
    assert any("there will be no contact" in line for line in said) == warned, said


@pytest.mark.parametrize("change, warned", [
    ({"block_upper": "8,4", "bodies": "block,top", "top_lower": "0,4.4", "top_upper": "8,8"}, "-bodies: 0.4 m are left between block and top, less than a cell"),
    ({"block_upper": "8,4", "bodies": "block,top", "top_lower": "0,4", "top_upper": "8,8"}, ""),
    ({"block_upper": "8,4", "bodies": "block,top", "top_lower": "0,5", "top_upper": "8,8", "boundary_y_upper": "fixed", "domain_upper": "12,13"}, ""),
    ({"block_upper": "3,8", "bodies": "block,right", "right_lower": "3.7,0", "right_upper": "8,8"}, "-bodies: 0.7 m"),
    ({"boundary_x_upper": "symmetry", "domain_upper": "9,12", "block_upper": "8.75,8"}, "-boundary_x_upper: 0.25 m are left between this side and body block"),
    ({"boundary_x_upper": "symmetry", "domain_upper": "9,12", "block_upper": "9,8"}, ""),
    ({"boundary_x_upper": "symmetry", "domain_upper": "9,12"}, ""),
    ({"boundary_x_lower": "symmetry", "block_lower": "0.5,0"}, "-boundary_x_lower: 0.5 m"),
    ({"bodies": "block,ball", "ball_shape": "disk", "ball_center": "9.9,4", "ball_radius": "1.4"}, "-bodies: 0.5 m"),
    ({"bodies": "block,ball", "ball_shape": "disk", "ball_center": "9.7,9.1", "ball_radius": "1.4"}, ""),
    ({"domain_upper": "9,12", "block_upper": "8.75,8"}, ""),
    ({"bodies": "ball", "ball_shape": "disk", "ball_center": "4,4", "ball_radius": 4}, "-boundary_y_lower: less than half a cell of 1 m lies between this side and body ball"),
    ({"block_upper": "8,2", "bodies": "block,ball", "ball_shape": "disk", "ball_center": "4,5", "ball_radius": 3}, "-bodies: less than half a cell of 1 m lies between block and ball"),
    ({"bodies": "ball", "ball_shape": "polygon", "ball_vertices": "1,0,7,0,8,4,7,8,1,8,0,4"}, "")])
def test_gaps_below_a_cell_give_a_warning(change, warned):
    """Bodies, or a body and a held side, so near move as if they touched: a load was that of one body, or of a body that is held."""
    case = {name: value for name, value in PRESS.items() if not name.startswith("block_") or "block" in change.get("bodies", "block")}
    said = warnings({**case, "indenter": "cylinder", "indenter_radius": 5, "max_steps": 2, **change})
    assert [line.startswith(WARNING + warned) for line in said] == [True] * bool(warned), said


@pytest.mark.parametrize("change, warned", [
    ({"top_velocity": "0,-1e-3"}, True), ({"top_velocity": "0,1e-3"}, True), ({"top_velocity": "1e-3,0"}, False), ({}, False),
    ({"top_velocity": "0,-1e-3", "top_lower": "0,5.1"}, False),
    ({"top_velocity": "0,-1e-3", "top_shape": "disk", "top_center": "4,6", "top_radius": 2, "top_lower": None, "top_upper": None}, True)])
def test_bodies_that_touch_and_move_on_each_other(change, warned):
    """They share nodes, and stay together, whatever the cells are."""
    case = {**PRESS, "bodies": "block,top", "block_upper": "8,4", "top_lower": "0,4", "top_upper": "8,8", "indenter": "cylinder",
            "indenter_radius": 5, "max_steps": 2, **change}
    said = warnings({name: value for name, value in case.items() if value is not None})
    assert any("block and top touch at the start" in line for line in said) == warned, said


# A block of 6 x 6 cells whose halves move against each other, so that it turns.
TURNING = {
    "domain_lower": "0,0", "domain_upper": "16,16", "cell_size": 1, "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1,
    "bodies": "left,right", "left_lower": "5,5", "left_upper": "8,11", "right_lower": "8,5", "right_upper": "11,11", "left_velocity": "0,-0.01",
    "right_velocity": "0,0.01", "end_time": 300, "frames": 0}


@pytest.mark.parametrize("change, words", [
    ({}, "noise of the points' velocities holds"), ({"xpic_fraction": 0.1}, "-bodies: energy balance: "), ({"left_velocity": "0,0.01"}, "")])
def test_bodies_that_turn_on_few_cells(change, words):
    """Their motion becomes noise, or XPIC takes it for that; not where they fly as they are."""
    said = warnings({**TURNING, **change, "end_time": 300 if words else 50})
    assert [words in line for line in said] == [True] * bool(words), said


def test_loads_after_the_end_give_a_warning():
    """Times in another unit."""
    case = {**BLOCK, "boundary_y_lower": "symmetry", "loads": "p", "p_side": "y_upper", "p_pressures": "0,1e5,1e5", "end_time": 1e-3}
    [line] = warnings({**case, "p_times": "0,1,2"})
    assert line.startswith(WARNING + "-p_times: the largest pressure of 1e+05 Pa comes after the end of the run at 0.001 s, by when it is at most 100 Pa")
    assert warnings({**case, "p_times": "0,5e-3,1"}) == []


def test_depths_that_count_from_below_what_is_met_first():
    """A punch over two pillars whose middle is above the gap between them goes on to the ground, and says so."""
    case = {**PRESS, "bodies": "block,left,right", "block_upper": "8,3", "left_lower": "0,3", "left_upper": "2,8", "right_lower": "6,3",
            "right_upper": "8,7", "indenter": "flat_punch", "indenter_width": 8, "max_steps": 2}
    said = warnings(case)
    assert len(said) == 1 and "depths count from the body below the tip; when the tip gets there" in said[0], said
    assert warnings({**case, "indenter_width": 3, "indenter_tip": "1,8"}) == [] and warnings({**case, "block_upper": "8,7.8", "left_lower": "0,7.8", "right_lower": "6,7.8", "right_upper": "8,8"}) == []


def test_body_that_flies_to_a_tip_at_rest_is_no_false_alarm():
    """A tip that waits for a body meets it, and gives the energy that the body brought, not more than its own work of nothing."""
    case = {**PRESS, "domain_upper": "12,14", "boundary_y_lower": "free", "block_lower": "0,1", "block_upper": "8,5", "block_velocity": "0,20",
            "indenter": "cylinder", "indenter_radius": 5, "indenter_tip": "4,5.5", "indenter_velocities": 0, "end_time": 0.1}
    said = warnings({name: value for name, value in case.items() if name not in ("indenter_max_depth", "max_steps")})
    assert len(said) == 1 and said[0].startswith(WARNING + "-boundary_y_lower: no body lies at a side"), said


@pytest.mark.parametrize("tip, peak, warned", [(8, 0.05, False), (11, 0.01, True)])
def test_load_that_is_missed_before_the_end_gives_a_warning(tip, peak, warned):
    """A test that ends without a load, and whose tip never came to carry the largest."""
    case = {**PRESS, "indenter": "cylinder", "indenter_radius": 5, "indenter_control": "load", "indenter_times": [0, peak, 2 * peak],
            "indenter_loads": "0,1e7,0", "damping": 30, "indenter_tip": f"4,{tip}", "domain_upper": "12,16"}
    for name in ("indenter_velocities", "indenter_max_depth"):
        del case[name]
    assert any("1e+07 N are asked for, and the tip carries at most" in line for line in warnings(case)) == warned


# ---- loads ----

def test_load_that_acts_on_a_part_of_its_side_gives_a_warning():
    two = {**BLOCK, "bodies": "a,b", "a_lower": "0,0", "a_upper": "4,8", "b_lower": "4,0", "b_upper": "8,4", "loads": "p", "p_body": "a",
           "p_side": "x_upper", "p_times": 0, "p_pressures": 1e3, "max_steps": 1, "block_lower": None, "block_upper": None}
    said = warnings({name: value for name, value in two.items() if not name.startswith("block")})
    assert len(said) == 1 and "-loads p: acts on 4 of the 8 m of its side" in said[0]


@pytest.mark.parametrize("span, acts", [("7,12", "1"), ("-3,2", "2"), ("-1,9", "8")])
def test_span_beyond_its_side_gives_a_warning(span, acts):
    load = {"loads": "p", "p_side": "y_upper", "p_times": 0, "p_pressures": 1e3, "max_steps": 1}
    said = warnings({**BLOCK, **load, "p_span": span})
    assert len(said) == 1 and f"-p_span {span}: reaches beyond the side of body block; the load acts on {acts} m" in said[0]
    assert warnings({**BLOCK, **load, "p_span": "2,8"}) == [] == warnings({**BLOCK, **load})


@pytest.mark.parametrize("pull, most", [(3e9, 0.15), (1e9, 0.01)])
def test_bar_that_is_pulled_to_twice_its_length_keeps_its_books(pull, most):
    """Of a metal, by a follower load: its loaded end once crumpled, and the bar kept a seventh of the work."""
    bar = {"domain_lower": "0,0", "domain_upper": "8e-6,40e-6", "cell_size": 0.5e-6, "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry",
           "materials": "m", "m_model": "j2", "m_youngs_modulus": 70e9, "m_poissons_ratio": 0.33, "m_density": 2700, "m_yield_stress": 1e8,
           "m_hardening_modulus": 2e9, "bodies": "b", "b_lower": "0,0", "b_upper": "4e-6,10e-6", "loads": "top", "top_side": "y_upper",
           "top_times": "0,300e-9", "top_pressures": f"0,{-pull}", "damping": 2e7, "end_time": 220e-9, "frames": 0}
    result = harness.run(bar)
    history = {name: column[-1] for name, column in result.history.items()}
    lost = history["external_work"] - history["kinetic_energy"] - history["strain_energy"] - history["dissipated_energy"]
    assert abs(lost) < most * history["external_work"] and result.summary["warnings"] == []


@pytest.mark.parametrize("cell, warned", [(0.5, True), (0.125, False)])
def test_energy_that_no_column_has_gives_a_warning(cell, warned):
    """Of the vibration of a block of 3 x 6 cells, whose waves few cells see."""
    case = {"domain_lower": "0,0", "domain_upper": "3,6", "cell_size": cell, "boundary_x_lower": "symmetry", "materials": "m",
            "m_youngs_modulus": 1e6, "m_poissons_ratio": 0.3, "m_density": 1000, "bodies": "b", "b_lower": "0,1", "b_upper": "1.5,4",
            "loads": "l,k", "l_side": "y_lower", "k_side": "y_upper", "end_time": 4, "frames": 0}
    for load in "lk":
        case |= {f"{load}_times": "0,0.02,0.04", f"{load}_pressures": "0,2e4,0"}
    assert [line.startswith(WARNING + "-bodies: energy balance: ") for line in warnings(case)] == [True] * warned


@pytest.mark.parametrize("ranks", ON_RANKS)
def test_load_that_bursts_a_body_on_levels(ranks):
    """Points that are lost at the domain's lower sides were put beside the arrays, and the run ended in a segmentation fault."""
    case = {**BLOCK, "geometry": "axisymmetric", "domain_upper": "16,20", "block_upper": "16,16", "boundary_x_lower": "symmetry",
            "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry", "levels": 2, "level_1_lower": "0,8", "level_1_upper": "8,20", "loads": "p",
            "p_side": "y_upper", "p_span": "0,4", "p_times": 0, "p_pressures": 3e10, "end_time": 0.1}
    assert "try a smaller -cfl" in refusal(case, ranks)
