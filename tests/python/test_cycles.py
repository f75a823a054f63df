"""Checks which parts of a curve are cycles and holds: unloadings in noise, partial ones, ringing, blows and relaxations."""
import math
import re

import numpy as np
import pytest

from made_curves import STIFFNESS, curve, cycles_of, metal
from mlgimp import load_depth, oliver_pharr

pytestmark = pytest.mark.fast


def test_each_cycle_has_its_row(expect):
    loads = (0.5, 1, 2, 5, 10)
    depth, load = cycles_of(loads)
    rows = oliver_pharr.analyse(curve(depth, load))
    assert [row["cycle"] for row in rows] == [1, 2, 3, 4, 5]
    expect("loads", np.max(np.abs(np.array([row["load_mN"] for row in rows]) / loads - 1)), at_most=1e-6)
    expect("hardness is the same", np.ptp([row["hardness_GPa"] for row in rows]) / rows[0]["hardness_GPa"], at_most=1e-4)
    expect("work that is plastic", np.ptp([row["plastic_share"] for row in rows]), at_most=2e-3)


@pytest.mark.parametrize("is_run", [False, True])
def test_small_unloadings_count(expect, is_run):
    """Ten, of which the first has a five hundredth of the largest load."""
    loads = 100 / 2.0 ** np.arange(9, -1, -1)
    rows = oliver_pharr.analyse(curve(*cycles_of(loads), is_run=is_run))
    assert [row["cycle"] for row in rows] == list(range(1, 11))
    expect("loads", np.max(np.abs(np.array([row["load_mN"] for row in rows]) / loads - 1)), at_most=1e-6)


def slow(random, size):
    """Noise of unit deviation that hardly changes from row to row: what it was 50 rows before counts by a third."""
    kept, noise = math.exp(-1 / 50), random.normal(size=size)
    for row in range(1, size):
        noise[row] = kept * noise[row - 1] + math.sqrt(1 - kept**2) * noise[row]
    return noise


@pytest.mark.parametrize("share, noise", [(0.001, np.random.Generator.normal), (0.003, np.random.Generator.normal), (0.005, slow)])
@pytest.mark.parametrize("hold", [0, 200])
@pytest.mark.parametrize("seed", range(5))
def test_unloadings_in_noise(share, noise, hold, seed):
    """Noise of a share of the largest load: those unloadings that fall by ten times as much are found, and none from less than three
    times it; slow noise that is as high as the lesser peaks may hide them, but makes no others."""
    loads = 10 / 2.0 ** np.arange(9, -1, -1)
    depth, load = cycles_of(loads)
    ends = np.flatnonzero(np.diff(np.sign(np.diff(depth)))) + 1
    depth, load = (np.insert(each, np.repeat(ends, hold), np.repeat(each[ends], hold)) for each in (depth, load))
    random, rows = np.random.default_rng(seed), len(depth)
    noisy = [0.05 * share, 10 * share] * np.column_stack([noise(random, size=rows) for _ in "hP"])
    found = load_depth.find_cycles(curve(*(np.column_stack([depth, load]) + noisy).T))
    tops = [load[cycle.start] for cycle in found]
    assert np.count_nonzero(loads > 100 * share / 0.9) <= len(tops) <= (10 if noise is slow else np.count_nonzero(loads > 30 * share))
    if noise is not slow:
        np.testing.assert_allclose(tops, loads[-len(tops):], rtol=0.05, atol=30 * share)


def test_partial_unloadings(expect):
    """To 0.8 of the load, where a lesser share of the load is left for the fit."""
    loads = (2, 4, 6, 8, 10)
    rows = oliver_pharr.analyse(curve(*cycles_of(loads, lowest=0.8)))
    assert len(rows) == 5 and not any("left out" in row["warnings"] for row in rows)
    expect("stiffness", rows[-1]["stiffness_mN_per_um"] / (10 * 1.4 / (0.16 * 0.5)) - 1, near=0, tolerance=0.01)


def test_a_reload_that_stops_early():
    """Two unloadings, of which the second begins in elastic contact, where load over area is no hardness."""
    depth, load = metal(lowest=0.1)
    down, back = slice(399, None), slice(None, 500, -1)
    depth, load = (np.concatenate([each[:399], each[down], each[back], each[501:]]) for each in (depth, load))
    first, second = oliver_pharr.analyse(curve(depth, load))
    assert first["warnings"] == "" and "here the contact is elastic" in second["warnings"] and second["load_mN"] < 8


def test_relaxations_are_no_unloadings():
    """Steps of the depth with holds in which the load relaxes by a tenth, with noise of the depth."""
    depth = np.concatenate([np.append(np.linspace(top - 0.1, top, 100), np.full(200, top)) for top in (0.1, 0.2, 0.3, 0.4)])
    load = 40 * depth**2 * np.tile(np.append(np.ones(100), 1 - 0.1 * (1 - np.exp(-np.linspace(0, 5, 200)))), 4)
    back = metal(top=0.4, load=load[-1], final=0.35)
    depth, load = np.append(depth, back[0][400:]), np.append(load, back[1][400:])
    for seed in range(5):
        noise = 2e-4 * np.random.default_rng(seed).normal(size=len(depth))
        assert len(load_depth.find_cycles(curve(depth + noise, load))) == 1


def test_an_unloading_that_cannot_be_fitted():
    """It has its number and its loads, and the others have their figures and numbers."""
    depth, load = cycles_of((1, 2, 5))
    few = np.ones(len(depth), bool)
    top = int(np.argmax(load > 2 - 1e-9))
    few[top + 1:top + 400] = np.arange(399) % 80 == 79
    rows = oliver_pharr.analyse(curve(depth[few], load[few]))
    assert [row["cycle"] for row in rows] == [1, 2, 3] and list(rows[1]) == list(rows[0]) == list(oliver_pharr.COLUMNS)
    assert math.isnan(rows[1]["hardness_GPa"]) and abs(rows[1]["load_mN"] - 2) < 1e-6 and math.isfinite(rows[2]["hardness_GPa"])
    assert re.match("left out: the load falls from 2 to 0.2 mN, and [0-4] rows of the unloading lie between", rows[1]["warnings"])


def test_waves_of_a_run_are_no_unloadings(capsys):
    """A staircase under the tip that goes on, and a ringing tip under load control, of which there is a note."""
    depth, load = metal(rows=2000)
    stairs = load * (1 + 0.15 * np.sin(2 * math.pi * depth / 0.02))
    assert len(load_depth.find_cycles(curve(depth, stairs, is_run=True))) == 1
    ring = np.sin(np.linspace(0, 40 * math.pi, 2000)) * np.linspace(0, 1, 2000)
    depth[:2000] += 0.01 * ring
    load[:2000] *= 1 + 0.05 * ring
    ringing = curve(depth, load, is_run=True)
    assert len(load_depth.find_cycles(ringing)) == 1
    [note] = load_depth.notes_on_waves(ringing)
    assert "times by less than 0.2 of itself while the tip goes back, which is taken for waves" in note
    assert list(load_depth.notes_on_waves(curve(*metal(), is_run=True))) == []


def test_an_unloading_that_rings():
    """Of a run: a wave in the unloading does not part it in two."""
    depth, load = metal(rows=1000, lowest=0.05)
    load[1000:] *= 1 + 0.2 * np.sin(np.linspace(0, 10 * math.pi, 999))
    [cycle] = load_depth.find_cycles(curve(depth, load, is_run=True))
    assert cycle.end > 1800


def test_ringing_before_is_no_cycle():
    """Blows of the first contact, and noise around zero load before it."""
    depth, load = metal()
    before = np.linspace(-0.1, 0, 200)
    load = load + 0.3 * np.maximum(np.sin(400 * depth), 0) * (depth < 0.06) * (np.arange(len(depth)) < 400)
    noisy = np.append(0.02 * np.random.default_rng(3).normal(size=200), load)
    assert len(load_depth.find_cycles(curve(np.append(before, depth), noisy))) == 1


def test_blows_are_no_peaks():
    """Spikes of some rows, more than twice the largest load and down to zero, also shortly before the unloading."""
    depth, load = metal()
    for row in (200, 300, 395):
        load[row:row + 3] = 25, 0, 2
    [row] = oliver_pharr.analyse(curve(depth, load))
    assert abs(row["stiffness_mN_per_um"] / STIFFNESS - 1) < 1e-6 and row["warnings"] == ""


def test_hold_under_displacement(expect):
    """The load relaxes by a tenth while the tip rests: the unloading begins where it ends."""
    depth, load = metal(rows=300)
    hold = 11 - np.minimum(1, np.linspace(0, 2, 120))
    [row] = oliver_pharr.analyse(curve(np.concatenate([depth[:300], np.full(120, 0.5), depth[300:]]),
                                       np.concatenate([1.1 * load[:300], hold, load[300:]])))
    expect("load", row["load_mN"], near=10, tolerance=1e-9)
    expect("stiffness", row["stiffness_mN_per_um"] / STIFFNESS - 1, near=0, tolerance=1e-5)
    assert row["warnings"] == ""


def test_hold_under_load(expect):
    """The tip creeps on; a nose makes a warning."""
    depth, load = metal(rows=300)
    creep = 0.5 - 0.02 * np.exp(-np.linspace(0, 6, 200))
    whole = np.concatenate([0.48 * depth[:300] / 0.5, creep, depth[300:]]), np.concatenate([load[:300], np.full(200, 10.0), load[300:]])
    [row] = oliver_pharr.analyse(curve(*whole))
    expect("stiffness", row["stiffness_mN_per_um"] / STIFFNESS - 1, near=0, tolerance=0.01)
    nose = np.linspace(10, 9, 50)
    [row] = oliver_pharr.analyse(curve(np.concatenate([depth[:300], 0.5 + np.linspace(0, 0.005, 50), depth[300:]]),
                                       np.concatenate([load[:300], nose, 0.9 * load[300:]])))
    assert "nose" in row["warnings"]
