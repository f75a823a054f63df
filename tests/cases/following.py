"""Boxes that follow the contact or a path: loads and energies as with boxes that stay, on any ranks and after a restart."""
import numpy
import pytest

import harness
import ranks as on_ranks
import studies_page as page
from limits import FAST

ALUMINIUM = {"materials": "al", "al_youngs_modulus": 70e9, "al_poissons_ratio": 0.33, "al_density": 2700, "bodies": "block", "frames": 2}

# Cells of 1 nm at the finest of four levels, which ends where 16 of them are half the contact's width.
CONE = {
    **ALUMINIUM, "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "400e-9,480e-9", "cell_size": 8e-9,
    "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry", "block_lower": "0,0", "block_upper": "400e-9,400e-9",
    "indenter": "cone", "indenter_half_angle": 70.3, "indenter_tip": "0,400e-9", "indenter_times": 0, "indenter_velocities": 60,
    "indenter_max_depth": 12e-9, "levels": 4, "level_follow": "contact", "level_cells_max": 16, "level_cells_min": 4}

# The tip comes down between two columns of cells, and the body is free at its sides.
WEDGE = {
    **{name: value for name, value in CONE.items() if name != "boundary_x_upper"}, "geometry": "plane_strain", "indenter": "wedge",
    "domain_lower": "-160e-9,0", "domain_upper": "160e-9,240e-9", "block_lower": "-160e-9,0", "block_upper": "160e-9,160e-9",
    "indenter_tip": "3.3e-9,160e-9", "indenter_max_depth": 8e-9}

SLIDE = {
    **{name: value for name, value in WEDGE.items() if name not in ("indenter_half_angle", "indenter_max_depth")},
    "indenter": "cylinder", "indenter_radius": 40e-9, "indenter_times": "0,3e-11,4e-11,1.6e-10", "indenter_velocities": "60,60,0,0",
    "indenter_velocities_x": "0,0,300,300", "end_time": 1.6e-10, "level_cells_max": 64}

# A quarter of a cone on three levels; half the contact's width is up to 5 cells of the finest.
SPACE = {
    **ALUMINIUM, "geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "96e-9,96e-9,120e-9", "cell_size": 8e-9, "blend_width": 2,
    "block_lower": "0,0,0", "block_upper": "96e-9,96e-9,96e-9", "block_points_per_cell": 1, "boundary_x_lower": "symmetry",
    "boundary_y_lower": "symmetry", "boundary_z_lower": "symmetry", "indenter": "cone", "indenter_half_angle": 70.3,
    "indenter_tip": "0,0,96e-9", "indenter_times": 0, "indenter_velocities": 100, "indenter_max_depth": 5.5e-9, "levels": 3,
    "level_follow": "contact", "level_cells_max": 3.5, "level_cells_min": 1}

# A block that a short pull along x leaves vibrating at about one per cent of strain while it flies; lengths in coarse cells.
FLIGHT = {
    "domain_lower": "0,0", "domain_upper": "48,20", "cell_size": 1, "levels": 2, "materials": "m", "m_youngs_modulus": 1,
    "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "block", "block_lower": "6,6", "block_upper": "14,14", "block_velocity": "0.2,0",
    "loads": "left,right", "left_side": "x_lower", "left_times": "0,4,5", "left_pressures": "-0.01,-0.01,0", "right_side": "x_upper",
    "right_times": "0,4,5", "right_pressures": "-0.01,-0.01,0", "end_time": 120, "frames": 1}

# A cylinder that is pressed on a long block and slides along it, with a box that goes along; lengths in coarse cells.
SCRATCH = {
    "domain_lower": "0,0", "domain_upper": "48,16", "cell_size": 1, "boundary_x_lower": "symmetry", "boundary_x_upper": "symmetry",
    "boundary_y_lower": "fixed", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "block",
    "block_lower": "0,0", "block_upper": "48,12", "indenter": "cylinder", "indenter_radius": 20, "indenter_tip": "12,12",
    "indenter_times": "0,40,50,450", "indenter_velocities": "0.02,0.02,0,0", "indenter_velocities_x": "0,0,0.02,0.02", "damping": 0.01,
    "end_time": 450, "levels": 2, "level_1_lower": "4,4", "level_1_upper": "20,16", "level_follow": "path", "level_1_times": "0,50,450",
    "level_1_path": "0,0,0,0,8,0", "frames": 0}


def fixed_boxes(case, sides):
    """The same case with boxes that stay, a row of lower and upper corners each."""
    fixed = {name: value for name, value in case.items() if not name.startswith("level_")}
    for k, (lower, upper) in enumerate(sides, 1):
        fixed |= {f"level_{k}_lower": lower, f"level_{k}_upper": upper}
    return {**fixed, "levels": len(sides) + 1}


def energy_left(history):
    """What is left of the energies at the end, less the work of the indenter, over its largest."""
    parts = sum(history[name][-1] for name in ("kinetic_energy", "strain_energy", "dissipated_energy"))
    return (parts - history["indenter_work"][-1]) / history["indenter_work"].max()


def warnings(result):
    """Those of a run, but of a loading within few transits of waves, as most here are."""
    return [line for line in result.summary["warnings"] if FAST not in line]


def expect_clean(expect, result, name=""):
    """Changes at each move, the steps of the load there, and what must be kept."""
    history, moves = result.history, result.summary["regrids"]
    work = numpy.interp([move["step"] for move in moves], history["step"], history["indenter_work"])
    expect(f"{name}energy of a move over the indenter's work, largest", max(abs(m["energy"]) / w for m, w in zip(moves, work) if w > 0), at_most=2e-4)
    momentum = numpy.sqrt(2 * history["kinetic_energy"].max() * history["mass"][0])
    expect(f"{name}momentum of a move, largest", max(m["momentum_error"] for m in moves) / momentum, at_most=1e-12)
    expect(f"{name}mass of a move, largest", max(m["mass_error"] for m in moves) / history["mass"][0], at_most=1e-14)
    expect(f"{name}points lost, mass error", abs(result.summary["points_lost"]) + abs(result.summary["mass_error"]), at_most=1e-14)
    expect(f"{name}energy left", energy_left(history), near=0, tolerance=0.01)
    expect.that(f"{name}warnings", warnings(result) == [], f"{warnings(result)}")
    expect.that(f"{name}points in levels that have ended", all(level["points"] == 0 for level, last in zip(result.summary["levels"][1:], last_moves(moves, result)) if not last))


def expect_pressures_at_moves(expect, result):
    """A frame of a step after which boxes moved has the pressures of contact on the points that carried the load."""
    from mlgimp import results
    history, steps = result.history, {move["step"] for move in result.summary["regrids"]}
    frames = {number: results.read_frame(path) for number, path in results.numbered_frames(result.folder).items()}
    loads = {number: numpy.interp(frame.time, history["time"], history["load"]) for number, frame in frames.items()}
    at_moves = [number for number, frame in frames.items() if frame.step in steps and loads[number] > 0]
    expect("frames at moves", len(at_moves), at_least=1)
    for number in at_moves:
        carried = harness.load_on_points(result.frame(number), hoop=True, up=numpy.sin(numpy.radians(70.3)))
        expect(f"load of the pressures on the points, frame {number}", carried / loads[number], near=1, tolerance=0.03)  # a row is the mean over a step


def last_moves(moves, result):
    """Whether each level from 1 on has points at the end."""
    active = dict.fromkeys(range(1, len(result.summary["levels"])), True)
    active.update({move["level"]: move["active"] for move in moves})
    return [active[k] for k in sorted(active)]


def test_cone(expect):
    """Seen: a move 2e-5 of the work, energy 5e-5, pressures 2.4 %, load 4e-4 and 3e-3, step 3e-4."""
    result = harness.run({**CONE, "frames": 24})
    expect_clean(expect, result)
    expect_pressures_at_moves(expect, result)
    fixed = harness.run(fixed_boxes(CONE, [("0,256e-9", "144e-9,480e-9"), ("0,320e-9", "64e-9,440e-9")])).history
    history = result.history
    depths = numpy.linspace(8e-9, 12e-9, 41)  # the coarser of the two has more than 6 cells in half the contact's width
    ratio = numpy.interp(depths, history["depth"], history["load"]) / numpy.interp(depths, fixed["depth"], fixed["load"])
    expect("load over that with boxes that stay, mean", numpy.mean(ratio), near=1, tolerance=0.003)
    expect("largest difference", numpy.max(numpy.abs(ratio - 1)), at_most=0.01)
    ended = [move["step"] for move in result.summary["regrids"] if not move["active"]]
    expect.that("one level ends", len(ended) == 1, f"{ended}")
    near = numpy.abs(history["step"] - ended[0]) <= 12
    fit = numpy.polynomial.Polynomial.fit(history["depth"][near], numpy.sqrt(history["load"][near]), 1)
    before, after = (numpy.mean((numpy.sqrt(history["load"]) / fit(history["depth"]))[part & near]) for part in
                     (history["step"] <= ended[0], history["step"] > ended[0]))
    expect("step in the load where it ends", (after / before) ** 2, near=1, tolerance=0.005)


def test_punch_touches_with_all_of_it_at_once(expect):
    """Seen: load 1.1e-3, energy 5.5e-3."""
    punch = {name: value for name, value in CONE.items() if name != "indenter_half_angle"}
    punch |= {"indenter": "flat_punch", "indenter_radius": 40e-9, "indenter_max_depth": 3e-9, "levels": 3, "level_cells_max": 64,
              "indenter_times": "0,1e-11", "indenter_velocities": "0,60"}  # no blow: its short waves are those of the levels
    result = harness.run(punch)
    fixed = harness.run(fixed_boxes(punch, [("0,200e-9", "160e-9,480e-9"), ("0,300e-9", "80e-9,440e-9")])).history
    expect.that("warnings", warnings(result) == [], f"{warnings(result)}")
    history, depths = result.history, numpy.linspace(0.3e-9, 2.9e-9, 27)
    ratio = numpy.interp(depths, history["depth"], history["load"]) / numpy.interp(depths, fixed["depth"], fixed["load"])
    expect("load over that with boxes that stay, largest difference", numpy.max(numpy.abs(ratio - 1)), at_most=0.01)
    expect("energy left", energy_left(history), near=0, tolerance=0.01)


def expect_same(expect, result, reference):
    """Equal histories and moves."""
    left = {**result.history}, {**reference.history}
    exchanged = [history.pop("exchange_energy") for history in left]  # what is left of several energies
    difference, column = on_ranks.largest_difference(*left)
    expect(f"history (worst column {column})", difference, at_most=1e-9)
    expect("exchange of energy", numpy.max(numpy.abs(exchanged[0] - exchanged[1])) / left[1]["strain_energy"].max(), at_most=1e-10)
    same = [[(m["step"], m["level"], m["lower"], m["upper"], m["split"], m["merged"]) for m in r.summary["regrids"]] for r in (result, reference)]
    expect.that("moves", same[0] == same[1] and len(same[0]) >= 4, f"{len(same[0])}")


@pytest.mark.mpi
def test_ranks_and_restart(expect):
    """Nothing depends on ranks, and a run goes on to the last digit from a checkpoint between two moves. Seen: a move 1.1e-5 of the work, energy
    1.2e-3."""
    case = {**CONE, "indenter_max_depth": 6e-9, "level_cells_max": 9, "level_cells_min": 2, "points_per_rank": 300,
            "checkpoint_interval": 115, "regrid_interval": 2}
    result = harness.run(case, ranks=3)
    expect_clean(expect, result)
    expect_same(expect, result, harness.run(case))
    again = harness.run({**case, "restart": result.folder / "checkpoint_000115.h5"}, ranks=3)
    rows = [(r.folder / "history.csv").read_text().splitlines()[-1] for r in (again, result)]
    expect.that("goes on to the last digit", rows[0] == rows[1], " and ".join(row[:60] for row in rows))
    expect.that("moves after a restart", again.summary["regrids"] == result.summary["regrids"])


@pytest.mark.mpi
def test_space(expect):
    """Seen: a move 1.1e-5 of the work, energy 9.9e-3."""
    result = harness.run(SPACE, ranks=2)
    expect_clean(expect, result)
    expect_same(expect, result, harness.run(SPACE))


def test_small_points_become_larger(expect):
    """Where strain changes like the logarithm of the way to a tip, families near it differ by as much for ever. Seen: a move 9e-5 of the work, load
    3e-3, small points 0.11."""
    from mlgimp import results
    result = wedge_from_first_touch(70.3, 7, 60e-9, level_cells_max=9, level_cells_min=2, frames=1)
    expect_clean(expect, result)
    expect("levels that have ended", sum(not active for active in last_moves(result.summary["regrids"], result)), at_least=3)
    depth, coefficient = load_coefficient(result.history, 1)
    later = depth > 20e-9
    difference = numpy.abs(coefficient[later] / numpy.mean(coefficient[later]) - 1)
    expect("load over the depth, largest difference from its mean", numpy.max(difference), at_most=0.01)
    levels = results.read_frame(results.find_frame(result.folder, None)).levels
    finest = max(k for k, level in enumerate(levels) if len(level["id"]))
    usual = 64e-9 / 2**finest / 4
    sizes = levels[finest]["half_size"][:, 0]
    expect("points a fourth of the usual size or less, over all of the finest level", numpy.mean(sizes < 0.3 * usual), at_most=0.15)


def test_between_two_columns(expect):
    expect_clean(expect, harness.run(WEDGE))


def test_box_moves_along_with_the_tip(expect):
    """Seen: middle 3.8 nm, of cells of 8 nm."""
    result = harness.run(SLIDE)
    expect_clean(expect, result)
    last = [move for move in result.summary["regrids"] if move["level"] == 3][-1]
    expect("middle of the finest box beyond the tip's start, nm", (last["lower"][0] + last["upper"][0]) * 5e8 - 3.3, near=1e9 * (result.history["tip_x"][-1] - 3.3e-9), tolerance=12)
    expect("way of the tip, nm", 1e9 * (result.history["tip_x"][-1] - 3.3e-9), at_least=30)


def test_levels_begin_as_the_contact_shrinks(expect):
    """Seen: energy 4.7e-3."""
    result = harness.run({**CONE, "indenter_max_depth": 6e-9, "level_cells_max": 9, "level_cells_min": 2.5, "indenter_unload_velocity": 60, "end_time": 1.9e-10})
    moves = result.summary["regrids"]
    expect_clean(expect, result)
    changes = [move["active"] for move in moves if move["level"] == 3]
    expect.that("the finest level ends and begins again", False in changes and changes[-1], f"{changes}")


def test_box_that_follows_a_flying_block(expect):
    """Against a box that holds the whole flight. Seen: 4e-3 and 0.0134."""
    stays = harness.run({**FLIGHT, "level_1_lower": "2,2", "level_1_upper": "44,18"}).history
    follows = harness.run({**FLIGHT, "level_1_lower": "2,2", "level_1_upper": "18,18", "level_follow": "path",
                           "level_1_times": "0,120", "level_1_path": "0,0,24,0"})
    times = numpy.linspace(6, 120, 200)
    vibration = [numpy.interp(times, h["time"], h["kinetic_energy"] - 0.5 * h["mass"] * 0.2**2 + h["strain_energy"])
                 for h in (follows.history, stays)]
    expect("energy of the vibration, largest difference", numpy.max(numpy.abs(vibration[0] / vibration[1] - 1)), at_most=0.01)
    expect("largest strain energy, as of a strain", numpy.sqrt(2 * stays["strain_energy"][stays["time"] < 20].max() / 64), near=0.012, tolerance=0.003)
    expect("mass of a move, largest", max(m["mass_error"] for m in follows.summary["regrids"]), at_most=1e-12)
    expect.that("moves", len(follows.summary["regrids"]) == 24, f"{len(follows.summary['regrids'])}")


def test_box_that_follows_a_sliding_tip(expect):
    """Against a box that holds all of its way; also under a load, which the finest level finds all the time. Seen: 6e-3 and 1.5e-3."""
    pressed = {name: value for name, value in SCRATCH.items() if name != "indenter_velocities"}
    pressed |= {"indenter_control": "load", "indenter_loads": "0,0.4,0.5,0.5"}
    for name, case, quantity in (("depth", SCRATCH, "load"), ("load", pressed, "depth")):
        follows, stays = (harness.run(case).history, harness.run(fixed_boxes(case, [("4,4", "30,16")])).history)
        times = numpy.linspace(60, 450, 400)
        by_path, by_box = (numpy.interp(times, h["time"], h[quantity]) for h in (follows, stays))
        expect(f"by {name}, {quantity}, largest difference", numpy.max(numpy.abs(by_path / by_box - 1)), at_most=0.01)


@pytest.mark.parametrize("changes, said", [
    ({"levels": 2, "indenter_max_depth": 3e-9}, "cells of level 1, fewer"),
    ({"levels": 2, "level_cells_max": 0.9, "level_cells_min": 0.1, "indenter_max_depth": 9e-9}, "cells of level 0 by time")])
def test_too_few_levels_give_a_warning(changes, said):
    lines = warnings(harness.run({**CONE, **changes}))
    assert [said in line for line in lines] == [True], lines


@pytest.mark.parametrize("changes", [{"level_cells_max": 9, "level_cells_min": 2, "regrid_interval": 1}, {"regrid_interval": 5}])
def test_points_that_fail(changes):
    """They may be anywhere: boxes do not move then, and what is flung into a finer level does not act beyond its grid."""
    result = harness.run({**CONE, "cfl": 1, "indenter_half_angle": 12, "frames": 0, **changes}, must_succeed=False)
    assert result.status == 1 and "deforms by more than a half" in result.stderr, f"status {result.status}: {result.stderr[-300:]}"


def work_by_depth(result):
    """Depths of the frames and the steps of points, of all levels, until then."""
    from mlgimp import results
    frames = [results.read_frame(path) for _, path in sorted(results.numbered_frames(result.folder).items())]
    steps = numpy.array([frame.step for frame in frames])
    per_step = numpy.array([sum(len(level["id"]) * 2**k for k, level in enumerate(frame.levels)) for frame in frames])
    depths = numpy.interp(steps, result.history["step"], result.history["depth"])
    return depths, numpy.concatenate([[0], numpy.cumsum(numpy.diff(steps) * (per_step[1:] + per_step[:-1]) / 2)])


def load_coefficient(history, exponent):
    """(depth, load over a power of it) of all rows: the load of a row is the mean since the one before, so the depth is too."""
    depth = numpy.convolve(history["depth"], (0.5, 0.5))[:-1]
    return depth, history["load"] / numpy.maximum(depth, 1e-12) ** exponent


def steps_at_ends(result, exponent):
    """Of the load over a power of the depth where levels end: the mean over a quarter more of depth over that before."""
    depth, coefficient = load_coefficient(result.history, exponent)
    active, changes = {}, []
    for move in result.summary["regrids"]:
        if active.get(move["level"], True) and not move["active"]:
            end = numpy.interp(move["step"], result.history["step"], result.history["depth"])
            before, after = (depth > end / 1.25) & (depth <= end), (depth > end) & (depth <= 1.25 * end)
            if before.any() and end * 1.25 <= depth[-1]:
                changes.append(abs(numpy.mean(coefficient[after]) / numpy.mean(coefficient[before]) - 1))
        active[move["level"]] = move["active"]
    return changes


def show_cost(study, result, exponent):
    """What depths cost, and what moves of boxes do."""
    history, moves = result.history, result.summary["regrids"]
    last = history["depth"][-1]
    octaves, decades = (numpy.diff(numpy.interp(last * shares, *work_by_depth(result)))
                        for shares in (2.0 ** numpy.arange(-4, 1), 10.0 ** numpy.arange(-2, 1)))
    study.expect("point-steps of a decade of depth over those of the one before, by the last four octaves",
                 (octaves[-1] / octaves[0]) ** (numpy.log2(10) / 3), at_most=1.2)
    study.figure("point-steps from a hundredth of the depth to a tenth", decades[0])
    study.figure("point-steps from a tenth of the depth to the end", decades[1])
    study.expect("step in the load where a level ends, largest of the last four", max(steps_at_ends(result, exponent)[-4:]), at_most=0.005)
    work = numpy.interp([move["step"] for move in moves], history["step"], history["indenter_work"])
    study.expect("energy of a move over the indenter's work, largest",
                 max(abs(m["energy"]) / w for m, w in zip(moves, work) if w > 0), at_most=2e-4)


def expect_constant(study, result, exponent, name, unit):
    """The load over a power of the depth, from where eight finest cells are half the contact's width."""
    history = result.history
    depth, coefficient = load_coefficient(history, exponent)
    full = history["contact_half_width"] >= 8e-9
    edges = numpy.geomspace(depth[full][0], depth[-1], 31)
    parts = [full & (depth > low) & (depth <= high) for low, high in zip(edges[:-1], edges[1:])]
    parts = [part for part in parts if part.any()]  # rows are few at the beginning
    middles, means = (numpy.array([numpy.mean(values[part]) for part in parts]) for values in (depth, coefficient))
    study.expect(f"{name} over its mean, largest difference", numpy.max(numpy.abs(means / numpy.mean(means) - 1)), at_most=0.02)
    study.expect("energy left over the work", energy_left(history), near=0, tolerance=0.01)
    study.figure("depth at the end over that with 8 cells in half the contact's width", depth[-1] / depth[full][0])
    study.figure(f"{name}, mean", numpy.mean(means) / 1e9, unit)
    study.plot(f"Load over the depth, {study.name}", "depth (µm)", f"{name} over its mean", page.curve(name, 1e6 * middles, means / numpy.mean(means)), log="x")


def verify_decades(study):
    """A cone from first touch over three decades of depth

    Elastic, in one run: boxes follow the contact, and levels end as it grows. The load over the square of the depth does not
    depend on the depth while the block is large.
    """
    size = 2**18 * 1e-9  # thirty times the contact's largest half width
    case = {**CONE, "levels": 13, "cell_size": 4096e-9, "domain_upper": f"{size},{size * 1.125}", "block_upper": f"{size},{size}",
            "indenter_tip": f"0,{size}", "indenter_velocities": 12, "indenter_max_depth": 4900e-9, "level_cells_max": 32,
            "level_cells_min": 8, "frames": 40}
    result = harness.run(case, timeout=7200)
    expect_constant(study, result, 2, "P/h2", "GPa")
    show_cost(study, result, 2)
    study.figure("moves of boxes", len(result.summary["regrids"]))


def wedge_from_first_touch(angle, levels, depth, coarse_cells=64, **options):
    """A wedge at a constant speed in a block so large that no wave comes back from its sides.

    In plane strain the depth under a load has the logarithm of the way to what holds the block. Here that is how far waves have
    come, which grows like the contact: with one speed and no length the motion of a half space is similar to itself.
    """
    cell = 2 ** (levels - 1) * 1e-9
    side = coarse_cells * cell
    case = {**CONE, "geometry": "plane_strain", "indenter": "wedge", "indenter_half_angle": angle, "levels": levels, "cell_size": cell,
            "domain_upper": f"{side},{side + 8 * cell}", "boundary_x_lower": "symmetry", "block_upper": f"{side},{side}",
            "indenter_tip": f"0,{side}", "indenter_max_depth": depth, "level_cells_max": 32, "level_cells_min": 8, "frames": 60,
            **options}
    return harness.run(case, timeout=7200)


def test_ten_levels_touch_at_once(expect):
    """What is half a coarse cell long of the surface is halved down to the finest of ten levels before the tip comes."""
    result = wedge_from_first_touch(70.3, 10, 10e-9, coarse_cells=32)
    expect("deepest place of the surface inside the indenter, finest cells", result.history["penetration"].max() / 1e-9, at_most=0.3)


def verify_wedge(study):
    """An elastic wedge in plane strain from first touch over two decades of depth

    In one run. Speed, depth and the way of the waves are all that has a length, so that the load over the depth is constant.
    """
    result = wedge_from_first_touch(70.3, 12, 2000e-9)
    expect_constant(study, result, 1, "P/h", "GN/m2")
    show_cost(study, result, 1)


def verify_metal_wedge(study):
    """A wedge in a metal that does not harden, in plane strain, from first touch over two decades of depth

    E is 200 yield stresses. Surface points at the tip are drawn out a hundred times and halved on the way.
    """
    result = wedge_from_first_touch(70.3, 11, 500e-9, al_model="j2", al_yield_stress=350e6, al_hardening_modulus=0,
                                    xpic_fraction=0.1)
    expect_constant(study, result, 1, "P/h", "GN/m2")
    show_cost(study, result, 1)
