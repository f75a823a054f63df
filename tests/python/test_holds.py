"""Checks holds in load-depth curves, creep and relaxation in them, and the stiffness without creep, on curves with exact figures."""
import csv
import json
import math

import numpy as np
import pytest

import harness  # noqa: F401 (finds the package)
from made_curves import CONE_OPTIONS, curve, main, metal, write_run
from mlgimp import creep, cycles, holds, load_depth, oliver_pharr, tips

pytestmark = pytest.mark.fast

MODULUS, TERMS = 3e9, ([0.2, 0.3], [2.0, 30.0])
PUNCH = tips.make_tip("flat_punch", radius=5.0)
STIFFNESS_OF_METAL = 10 * 1.4 / 0.08
STIFFNESS = 2 * MODULUS / (1 - 0.3**2) * 5e-6 * 1e-3  # mN/um of the punch at once


def rows_of(corners, uneven=False, count=600):
    """Times (s) between corners, evenly, or first dense and then sparse after each, as a program writes them."""
    way = np.linspace(0, 1, count)
    way = way**3 if uneven else way
    return np.unique(np.concatenate([first + (last - first) * way for first, last in zip(corners, corners[1:])]))


def punch(corners, loads, noise=0.0, uneven=False, seed=1, count=600):
    """The curve of a punch on a viscoelastic body under loads (mN) at corners (s): exact, as its contact does not change."""
    time, random = rows_of(corners, uneven, count), np.random.default_rng(seed)
    load = np.interp(time, corners, loads)
    depth = creep.history_integral(time, corners, loads, 1.0, *creep.retardation(*TERMS)) / STIFFNESS
    depth, load = depth + 0.1 * noise * depth.max() * random.normal(size=len(time)), load + noise * max(loads) * random.normal(size=len(time))
    return curve(depth, load, tip=PUNCH, time=time)


def creep_of(corners, loads, first, last):
    """C_IT in % between two times, from the exact depths."""
    h1, h2 = creep.history_integral([first, last], corners, loads, 1.0, *creep.retardation(*TERMS))
    return 100 * (h2 / h1 - 1)


HELD = (0, 10, 40, 44), (0, 5, 5, 0)
TESTS = {
    "even": (HELD, {}), "uneven": (HELD, {"uneven": True}), "noise of 0.2 %": (HELD, {"noise": 2e-3}), "noise of 1 %": (HELD, {"noise": 1e-2}),
    "hold at a tenth before": (((0, 2, 30, 40, 70, 74), (0, 0.5, 0.5, 5, 5, 0)), {}),
    "hold at a tenth after": (((0, 10, 40, 44, 144, 145), (0, 5, 5, 0.5, 0.5, 0)), {"noise": 2e-3}),
    "hold without load before": (((0, 50, 60, 90, 94), (0, 0, 5, 5, 0)), {}),
    "overshoot": (((0, 10, 10.4, 10.8, 40, 44), (0, 5, 5.2, 5, 5, 0)), {}),
    "load that drifts up": (((0, 10, 40, 44), (0, 5, 5.02, 0)), {}), "load that drifts down": (((0, 10, 40, 44), (0, 5, 4.98, 0)), {}),
    "few rows": (((0, 10, 12, 22), (0, 5, 5, 0)), {"count": 21}),
    "short hold": (((0, 10, 12, 22), (0, 5, 5, 0)), {}),
}


@pytest.mark.parametrize("name", TESTS)
def test_creep(expect, name):
    """C_IT within 2 % of itself, and times within 2 % of the hold, of that where the load first reaches the level; with noise 5 %."""
    (corners, loads), more = TESTS[name]
    [row] = oliver_pharr.analyse(punch(corners, loads, **more))
    held = corners[next(k for k, load in enumerate(loads) if load > 4.5)], corners[max(k for k, load in enumerate(loads) if load > 4.5)]
    tolerance = 0.05 if more.get("noise", 0) > 5e-3 else 0.02
    expect("begin", (row["hold_start_s"] - held[0]) / (held[1] - held[0]), near=0, tolerance=tolerance)
    expect("end", (row["hold_end_s"] - held[1]) / (held[1] - held[0]), near=0, tolerance=tolerance)
    expect("C_IT", row["C_IT_percent"] / creep_of(corners, loads, *held) - 1, near=0, tolerance=tolerance)
    assert math.isnan(row["R_IT_percent"])


@pytest.mark.parametrize("noise", [0, 3e-3])
def test_rate_of_creep(expect, noise):
    """At the end of a hold, from the exact depths; and of the unloading."""
    corners, loads = (0, 5, 20, 22), (0, 5, 5, 0)
    [row] = oliver_pharr.analyse(punch(corners, loads, noise))
    before, after = creep.history_integral([20 - 1e-6, 20], corners, loads, 1.0, *creep.retardation(*TERMS)) / STIFFNESS
    expect("rate of creep", row["creep_rate_um_per_s"] / ((after - before) / 1e-6) - 1, near=0, tolerance=0.05 if noise == 0 else 0.12)
    expect("rate of unloading, mN/s", row["unloading_rate_mN_per_s"], near=-2.5, tolerance=0.03)


@pytest.mark.parametrize("seconds", [3, 30, 100, 300])
def test_stiffness_without_creep(expect, seconds):
    """A metal that flows on in its unloading as the cube of the load: what is left of 0.8, 9 and 30 %, is within 2 %, of a nose within 7 %."""
    depth, load = metal(rows=2000)
    hold, down = np.linspace(0, 20, 1001)[1:], np.linspace(0, 1, 4001)[1:]
    share, rate = 1 - down, 2e-4
    crept, flow = rate * hold, rate * seconds * (1 - (1 - down) ** 4) / 4
    time = np.concatenate([np.linspace(0, 10, 2000), 10 + hold, 30 + seconds * down])
    depth = np.concatenate([depth[:2000], 0.5 + crept, 0.42 + 0.08 * share ** (1 / 1.4) + crept[-1] + flow])
    for noise in (0, 3e-3):
        random = np.random.default_rng(1)
        noisy = np.concatenate([load[:2000], np.full(1000, 10.0), 10 * share]) * (1 + noise * random.normal(size=len(depth)))
        [row] = oliver_pharr.analyse(curve(depth + 1e-2 * noise * random.normal(size=len(depth)), noisy, time=time))
        expect("rate of creep, um/s", row["creep_rate_um_per_s"], near=rate, tolerance=1e-2 * rate if noise == 0 else 0.1 * rate)
        expect("stiffness as it is", row["stiffness_mN_per_um"] / STIFFNESS_OF_METAL - 1, at_least=0.004)
        expect("stiffness without creep", row["corrected_stiffness_mN_per_um"] / STIFFNESS_OF_METAL, near=1, tolerance=0.02 if seconds < 300 else 0.07)
        assert row["corrected_hardness_GPa"] > 0 and row["corrected_modulus_GPa"] > 0


def test_what_does_not_creep_has_no_figures_of_creep(tmp_path):
    """A hold of a run whose materials do not flow with the time; in a measured curve nobody knows."""
    depth, load = metal(rows=300)
    depth, load = (np.concatenate([each[:300], np.full(300, each[299]), each[300:]]) for each in (depth, load))
    hold = curve(depth, load, time=np.linspace(0, 30, len(depth)))
    rows = [oliver_pharr.analyse(hold._replace(creeps=known))[0] for known in (None, True, False)]
    assert [math.isfinite(row["corrected_hardness_GPa"]) for row in rows] == [True, True, False]
    assert [row["C_IT_percent"] == pytest.approx(0, abs=1e-9) for row in rows] == [True, True, False] and rows[2]["hold_end_s"] > rows[2]["hold_start_s"]
    assert math.isnan(rows[2]["C_IT_percent"]) and math.isnan(rows[2]["corrected_stiffness_mN_per_um"])
    assert [any("no material of the run creeps" in note for note in oliver_pharr.notes_on([row])) for row in rows] == [False, False, True]
    for options, known in (({}, False), ({"-m_rate_law": "none", "-m_model": "j2"}, False), ({"-m_rate_law": "norton"}, True),
                           ({"-m_model": "viscoelastic"}, True)):
        assert load_depth.creeps(options) == known


def test_relaxation(expect):
    """R_IT of a cone that is held at its depth, by the load's exact integral; the depth is measured with noise, too."""
    corners, depths = (0, 5, 60, 61), (0, 0.5, 0.5, 0.2)
    time = rows_of(corners, uneven=True)
    depth = np.interp(time, corners, depths)
    load = 1e3 * creep.lee_radok_load(time, time, 1e-6 * depth, MODULUS, 0.3, *TERMS, half_angle=70.3)
    exact = 1e3 * creep.lee_radok_load([5, 60], time, 1e-6 * depth, MODULUS, 0.3, *TERMS, half_angle=70.3)
    for noise in (0, 1e-4):
        random = np.random.default_rng(2)
        [row] = oliver_pharr.analyse(curve(depth + noise * random.normal(size=len(time)), np.maximum(load, 0), time=time))
        expect("R_IT", row["R_IT_percent"] / (100 * (1 - exact[1] / exact[0])) - 1, near=0, tolerance=0.02)
        expect("end", row["hold_end_s"], near=60, tolerance=0.6)
        assert all(math.isnan(row[name]) for name in ("C_IT_percent", "creep_rate_um_per_s", "corrected_hardness_GPa"))


def test_no_hold():
    """A sharp turn, a smooth one, a curve without times, and one whose holds are of a tenth of the load."""
    depth, load = metal()
    ramp = np.linspace(-1, 1, len(depth))
    smooth = 5 * np.cos(np.pi / 2 * ramp) ** 2
    thermal = punch((0, 2, 30, 40, 50), (0, 0.5, 0.5, 5, 0))
    sharp = [metal(rows=rows) for rows in (30, 60, 100, 200, 400, 1000, 5000)]
    for each in (*(curve(*made, time=np.linspace(0, 20, len(made[0]))) for made in sharp), curve(depth, load), curve(smooth / STIFFNESS, smooth, time=10 + 10 * ramp), thermal,
                 curve(depth, load, time=np.zeros(len(depth)))):
        [cycle] = cycles.find_cycles(each)
        assert holds.find_hold(each, cycle) is None
        [row] = oliver_pharr.analyse(each)
        assert all(math.isnan(row[name]) for name in oliver_pharr.HELD)


def test_metal_that_creeps_little(expect):
    """By 0.2 % of the depth: not taken for a hold of the depth."""
    depth, load = metal(rows=300)
    hold = np.linspace(0, 1, 301)[1:]
    depth = np.concatenate([depth[:300], 0.5 + 1e-3 * hold**0.3, depth[300:] + 1e-3])
    load = np.concatenate([load[:300], np.full(300, 10.0), load[300:]])
    [row] = oliver_pharr.analyse(curve(depth, load, time=np.concatenate([np.linspace(0, 10, 300), 10 + 5 * hold, np.linspace(15, 25, 300)[1:]])))
    expect("C_IT", row["C_IT_percent"], near=0.2, tolerance=0.02)


def test_files_have_what_a_hold_gives(tmp_path, capsys):
    """In indentation.json and .csv and as lines; null, empty and none without a column of times."""
    made = punch(*HELD)
    np.savetxt(tmp_path / "m.csv", np.column_stack([made.time, made.depth, made.load]), delimiter=",", header="time,depth,load", comments="")
    words = [str(tmp_path / "m.csv"), "--tip", "flat_punch", "--radius", "5", "--poisson", "0.3"]
    main([*words, "--time", "time:s"])
    [cycle] = json.loads((tmp_path / "indentation.json").read_text())["curves"][0]["cycles"]
    [row] = csv.DictReader(open(tmp_path / "indentation.csv"))
    printed = capsys.readouterr().out
    assert float(row["C_IT_percent"]) == cycle["C_IT_percent"] > 5 and "creep C_IT" in printed and "stiffness without creep" in printed
    assert cycle["R_IT_percent"] is None and row["R_IT_percent"] == ""
    np.savetxt(tmp_path / "m.csv", np.column_stack([made.depth, made.load]), delimiter=",", header="depth,load", comments="")
    main(words)
    [cycle] = json.loads((tmp_path / "indentation.json").read_text())["curves"][0]["cycles"]
    assert all(cycle[name] is None for name in oliver_pharr.HELD) and "creep" not in capsys.readouterr().out


def test_runs_have_the_time_of_their_test(tmp_path):
    """The column test_time counts, not the time of the program, without which a run has no figures of a hold."""
    folder = write_run(tmp_path / "run", {**CONE_OPTIONS, "-m_rate_law": "norton"})
    [row] = oliver_pharr.analyse(oliver_pharr_curve(folder))
    assert math.isnan(row["C_IT_percent"])
    lines = (folder / "history.csv").read_text().splitlines()
    names, rows = lines[0].split(","), [line.split(",") for line in lines[1:]]
    top = max(range(len(rows)), key=lambda row: float(rows[row][names.index("depth")]))
    held = [[*rows[top]] for _ in range(200)]
    for k, each in enumerate(held):
        each[names.index("depth")] = repr(float(rows[top][names.index("depth")]) * (1 + 1e-4 * (k + 1)))
    later = [[*each] for each in rows[top + 1:]]
    for each in later:
        each[names.index("depth")] = repr(float(each[names.index("depth")]) + 0.02 * 0.5e-6)
    rows = rows[:top + 1] + held + later
    seconds = np.concatenate([np.linspace(0, 10, top + 1), 10 + 0.2 * np.arange(1, 201), 50 + np.linspace(0, 10, len(later) + 1)[1:]])
    for k, each in enumerate(rows):
        each[names.index("time")] = repr(1e-9 * k)
    (folder / "history.csv").write_text("\n".join([",".join([*names, "test_time"]), *(",".join([*each, repr(float(s))]) for each, s in zip(rows, seconds))]) + "\n")
    [row] = oliver_pharr.analyse(oliver_pharr_curve(folder))
    assert row["C_IT_percent"] == pytest.approx(2, abs=0.1) and row["hold_start_s"] == pytest.approx(10, abs=0.5) and row["hold_end_s"] == pytest.approx(50, abs=0.5)


def oliver_pharr_curve(folder):
    """The curve of a run that write_run() made."""
    from mlgimp import load_depth
    return load_depth.read_run(folder)
