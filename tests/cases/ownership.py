"""Points stay with the ranks that own their nodes, whatever they do: small cases that once lost that on several ranks."""
import re

import pytest

import harness
from limits import refusal
from ranks import SAME, largest_difference

MATERIAL = {"materials": "m", "m_youngs_modulus": 1e7, "m_poissons_ratio": 0.3, "m_density": 1000, "frames": 0, "bodies": "b"}
ON_RANKS = [1, *(pytest.param(ranks, marks=pytest.mark.mpi) for ranks in (2, 4))]


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 4])
def test_migration_of_a_body_that_slows_down(ranks):
    """Migration was due at multiples of an interval that grew with the steps: it was missed for hundreds of steps."""
    case = {**MATERIAL, "domain_lower": "0,0", "domain_upper": "60,14", "cell_size": 1, "b_lower": "5,3", "b_upper": "25,11",
            "b_velocity": "21.1,0", "damping": 1.6666667, "time_step": 2e-3, "max_steps": 620, "points_per_rank": 1,
            "rebalance_threshold": 1000, "history_interval": 20}
    difference, column = largest_difference(harness.run(case, ranks=ranks).history, harness.run(case).history)
    assert difference <= SAME, column


RECUT = {"thickness": 1e-6, "domain_lower": "0,0", "domain_upper": "30e-6,12e-6", "cell_size": 500e-9, "levels": 2,
         "level_1_lower": "3e-6,4e-6", "level_1_upper": "27e-6,8e-6", "materials": "soft", "soft_youngs_modulus": 70e9,
         "soft_poissons_ratio": 0.33, "soft_density": 2700, "bodies": "blk", "blk_lower": "4e-6,3e-6", "blk_upper": "10e-6,9e-6",
         "blk_velocity": "1500,0", "loads": "a,b", "a_side": "x_lower", "a_times": 0, "a_pressures": 1e9, "b_side": "x_upper",
         "b_times": 0, "b_pressures": 8e8, "end_time": 8e-9, "frames": 1, "points_per_rank": 1, "rebalance_threshold": 1.5}


@pytest.mark.mpi
@pytest.mark.parametrize("coupling", ["points", "nodes"])
def test_copies_follow_a_re_cut(coupling):
    """Copies of points stayed on ranks that no longer had their nodes: strain energy was up to 4 % off."""
    case = {**RECUT, "level_coupling": coupling}
    alone = harness.run(case).history
    for ranks in (2, 4):
        difference, column = largest_difference(harness.run(case, ranks=ranks).history, alone)
        assert difference <= (1e-6 if coupling == "points" else SAME), (ranks, column)  # copies spread round-off


@pytest.mark.parametrize("ranks", ON_RANKS)
def test_points_beyond_the_grid_of_a_finer_level(ranks):
    """Half a coarse cell beyond the domain is several fine ones: such a point was sent to rank -1."""
    case = {**MATERIAL, "domain_lower": "0,0", "domain_upper": "20,12", "cell_size": 1, "levels": 2, "refinement_ratio": 8,
            "level_1_lower": "8,4", "level_1_upper": "16,12", "b_lower": "2,6", "b_upper": "6,12", "b_velocity": "10,3.388",
            "end_time": 0.3}
    assert "left the grid; try a larger domain" in refusal(case, ranks)


def test_places_in_space_have_three_coordinates():
    case = {**MATERIAL, "geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "6,6,6", "cell_size": 1, "b_lower": "2,2,2", "b_upper": "4,4,4",
            "b_velocity": "0,0,10", "end_time": 0.5}
    assert re.search(r"at \(\S+, \S+, [67]\.\S+\) left the grid", refusal(case, 1))


@pytest.mark.parametrize("ranks", ON_RANKS)
def test_a_body_that_blows_up_between_levels(ranks):
    """The message names the failed point and the time, and summary.json has the status."""
    case = {**MATERIAL, "domain_lower": "0,0", "domain_upper": "24,20", "cell_size": 1, "levels": 2, "level_1_lower": "10,2",
            "level_1_upper": "20,18", "b_lower": "4,5", "b_upper": "9,14", "b_velocity": "40,0", "loads": "p", "p_side": "y_upper",
            "p_times": "0,0.02,0.0201", "p_pressures": "0,0,1e8", "end_time": 1, "history_interval": 10}
    result = harness.run(case, ranks=ranks, must_succeed=False)
    lines = harness.lines_of(result.stderr)
    assert result.status == 1 and len(lines) == 1 and "level" in lines[0] and "point" in lines[0], lines
    assert result.summary["status"].startswith("failed: time")


@pytest.mark.mpi
def test_a_level_that_begins_empty_takes_more_ranks(expect):
    """A body flies into it; on its way out it gives the ranks back."""
    case = {**MATERIAL, "domain_lower": "0,0", "domain_upper": "20,12", "cell_size": 1, "levels": 2, "level_1_lower": "8,3",
            "level_1_upper": "16,10", "b_lower": "1,5", "b_upper": "6,9", "b_velocity": "10,0", "end_time": 0.6, "points_per_rank": 60}
    results = {ranks: harness.run(case, ranks=ranks) for ranks in (1, 2, 3)}
    for ranks in (2, 3):
        used = [level["ranks"] for level in results[ranks].summary["levels"]]
        points = [level["points"] for level in results[ranks].summary["levels"]]
        expect.that(f"{ranks} ranks: points {points} on {used}", used[1] == ranks and used[0] == 1)
        difference, column = largest_difference(results[ranks].history, results[1].history)
        expect(f"{ranks} ranks: history (worst column {column})", difference, at_most=SAME)
