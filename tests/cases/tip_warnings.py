"""A tip whose load is not its own is refused or makes a warning: near a side of symmetry or beyond it, which cuts or mirrors it, or on few cells."""
import pytest

import harness
from limits import FEW_CELLS, PRESS, warnings

TIP = {**PRESS, "indenter": "cylinder", "indenter_radius": 5, "boundary_x_lower": "symmetry", "cell_size": 0.5, "frames": 0}
IN_SPACE = {**TIP, "geometry": "3d", "cell_size": 1, "domain_upper": "12,12,12", "block_lower": "0,0,0", "block_upper": "8,8,8", "domain_lower": "0,0,0",
            "boundary_y_lower": "symmetry", "boundary_z_lower": "symmetry", "indenter": "pyramid", "indenter_faces": 4, "indenter_half_angle": 68}
del IN_SPACE["indenter_radius"]
PLATE = {**TIP, "boundary_x_upper": "symmetry", "domain_upper": "8,12", "indenter": "flat_punch", "indenter_width": 20, "indenter_max_depth": 0.1}
del PLATE["indenter_radius"]
BY_LOAD = {**TIP, "indenter_control": "load", "indenter_times": "0,0.02", "indenter_loads": "0,8e8", "end_time": 0.02}
del BY_LOAD["indenter_velocities"], BY_LOAD["indenter_max_depth"]


def test_tip_near_a_side_of_symmetry():
    """On the side within round-off, or half a cell away; between them it would be half a tip that counts as a whole one, and is refused."""
    for place in ("1e-10,8.5", "0.25,8.5"):
        assert not any("symmetry" in line for line in warnings({**TIP, "indenter_tip": place, "max_steps": 2}))


@pytest.mark.parametrize("case, tip, warned", [
    (TIP, "1,8", True), (TIP, "1.75,8", True), (TIP, "4,8", False), (TIP, "0,8", False),
    (PLATE, "3,8", False), (IN_SPACE, "0,0.5,8", True),
    (BY_LOAD, "1,8", True)])
def test_contact_that_meets_its_mirror_image(case, tip, warned):
    """A tip near a side of symmetry and its image are two that have met: the load of a half model is up to 40 % too large."""
    met = [line for line in harness.run({**case, "indenter_tip": tip}).summary["warnings"] if "the load is that of two indenters" in line]
    assert len(met) == warned and all("_lower by time" in line for line in met), met


@pytest.mark.parametrize("change, warned", [
    ({}, True), ({"cell_size": 0.25}, False), ({"levels": 2, "level_1_lower": "0,4", "level_1_upper": "8,12"}, False),
    ({"block_upper": "2,8", "indenter": "flat_punch", "indenter_width": 20}, False), ({"indenter": "flat_punch", "indenter_width": 2}, True)])
def test_contact_of_few_cells_gives_a_warning(change, warned):
    """Where a tip stands between columns counts for a third of the load there; a plate over the whole end of a body has no such place."""
    tip = {"indenter_max_depth": 0.3, "boundary_x_lower": "symmetry", "indenter_tip": "0,8"}
    shape = change if "indenter" in change else {"indenter": "cylinder", "indenter_radius": 4, **change}
    said = warnings({**PRESS, **tip, **shape}, but=())
    assert [FEW_CELLS in line for line in said].count(True) == warned, said


@pytest.mark.parametrize("ratio, average, warned", [(0.499, "false", True), (0.49, "false", True), (0.48, "false", False), (0.499, "true", False)])
def test_cells_that_lock_give_a_warning(ratio, average, warned):
    """At a ratio of 0.499 the load of a cylinder on one cell of contact is 1.6 times that of a fine grid."""
    said = warnings({**TIP, "indenter_tip": "0,8", "al_poissons_ratio": ratio, "al_volume_average": average, "max_steps": 2}, but=())
    assert ["hardly changes its volume" in line for line in said].count(True) == warned, said
