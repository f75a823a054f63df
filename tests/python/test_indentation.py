"""Checks the analysis of indentation tests on exact curves: fits, tips, cycles, holds, parts of models, refusals."""
import csv
import json
import math
import re
import runpy

import numpy as np
import pytest

import harness
import mlgimp
from mlgimp import load_depth, oliver_pharr, tips
from mlgimp.errors import ResultError
from mlgimp.load_depth import Curve
from mlgimp.oliver_pharr import Constants
from mlgimp.pictures import plt
from test_scripts import HISTORY

pytestmark = pytest.mark.fast

main = runpy.run_path(str(harness.ROOT / "scripts" / "indentation.py"))["main"]  # a module of that name is in tests/cases
CONE = tips.make_tip("cone", half_angle=70.3)
TAN = math.tan(math.radians(70.3))


def curve(depth, load, area=None, tip=CONE, poisson=0.3, time=None, is_run=False):
    cells, block = (np.full(len(depth), 8.0), np.full(len(depth), 20.0)) if is_run else (None, None)
    return Curve("test", time, np.array(depth, float), np.array(load, float), area, tip, poisson, False, [], cells, block)


def metal(top=0.5, load=10.0, final=0.42, exponent=1.4, rows=400, lowest=0.0, first=0.0):
    """Depth (um) and load (mN): load c h^2 up to a largest depth, then the power law down to a share of the load."""
    up = np.linspace(first, top, rows)
    down = top - (top - final) * (1 - lowest ** (1 / exponent)) * np.linspace(0, 1, rows)[1:]
    return np.append(up, down), np.append(load * (up / top) ** 2, load * ((down - final) / (top - final)) ** exponent)


STIFFNESS = 10 * 1.4 / 0.08  # of metal()


def text_of(depth, load, mark=",", head="depth,load\n"):
    return head + "".join(f"{h:.9g}{mark}{p:.9g}\n" for h, p in zip(depth, load))


# ---- the fit ----

def test_power_law_is_found_again(expect):
    depth, load = metal()
    [row] = oliver_pharr.analyse(curve(depth, load))
    for name, exact in (("stiffness_mN_per_um", STIFFNESS), ("exponent", 1.4), ("final_depth_um", 0.42), ("load_mN", 10), ("depth_um", 0.5)):
        expect(name, row[name] / exact - 1, near=0, tolerance=1e-6)
    total, elastic = 10 * 0.5 / 3, 10 * 0.08 / 2.4
    expect("plastic over total work", row["plastic_share"], near=1 - elastic / total, tolerance=1e-4)
    assert row["warnings"] == ""


@pytest.mark.parametrize("window", [(0.5, 0.97), (0.2, 0.98)])
def test_noise(expect, window):
    """Noise of 0.5 % of the load and 0.02 % of the depth, in holds as well: the stiffness within three of its standard errors."""
    depth, load = metal()
    depth, load = (np.insert(each, 400, np.full(150, each[399])) for each in (depth, load))
    random = np.random.default_rng(2)
    rows = [oliver_pharr.analyse(curve(depth + 1e-4 * random.normal(size=len(depth)), load + 0.05 * random.normal(size=len(load))),
                                 Constants(window=window))[0] for _ in range(20)]
    errors = np.array([row["stiffness_mN_per_um"] / STIFFNESS - 1 for row in rows])
    told = np.mean([row["stiffness_error_mN_per_um"] for row in rows]) / STIFFNESS
    expect("mean error of the stiffness", np.mean(errors), near=0, tolerance=0.01)
    expect("largest, of the standard error told", np.max(np.abs(errors)) / told, at_most=3.5)
    expect("load at the start", np.max([abs(row["load_mN"] / 10 - 1) for row in rows]), at_most=0.003)


def test_elastic_cone_by_sneddon_and_hay(expect):
    """P = beta 2/pi E/(1 - nu^2) tan h^2 gives E with Hay's beta, 1.067, and 1.067 E with 1; epsilon is 2 - 4/pi, for which .72 is used."""
    modulus, depth = 70.0, np.append(np.linspace(-0.1, 0.6, 300), np.linspace(0.6, 0, 300)[1:])
    beta = tips.hay(TAN, 0.3)
    load = beta * 2 / np.pi * modulus / 0.91 * TAN * np.maximum(depth, 0) ** 2
    [exact] = oliver_pharr.analyse(curve(depth, load), Constants(epsilon=2 - 4 / np.pi))
    [usual] = oliver_pharr.analyse(curve(depth, load))
    [alone] = oliver_pharr.analyse(curve(depth, load), Constants(epsilon=2 - 4 / np.pi, beta=1))
    expect("beta", beta, near=1.067, tolerance=5e-4)
    expect("E", exact["modulus_GPa"] / modulus, near=1, tolerance=1e-5)
    expect("E with epsilon .72", usual["modulus_GPa"] / modulus, near=2 / np.pi / 0.64, tolerance=1e-5)
    expect("E with beta 1", alone["modulus_GPa"] / modulus, near=beta, tolerance=1e-4)
    expect("plastic work", usual["plastic_share"], near=0, tolerance=1e-4)


def test_elastic_sphere_and_punch(expect):
    """Hertz's load and Sneddon's punch give E with epsilon .75 and 1; the area of the sphere is that of its true section, a^2 = 2 R h_c - h_c^2."""
    modulus, radius = 70 / 0.91, 10.0
    depth = np.append(np.linspace(0, 0.05, 300), np.linspace(0.05, 0, 300)[1:])
    [sphere] = oliver_pharr.analyse(curve(depth, 4 / 3 * modulus * math.sqrt(radius) * depth**1.5, tip=tips.make_tip("sphere", radius=radius)))
    [punch] = oliver_pharr.analyse(curve(depth, 2 * modulus * radius * depth, tip=tips.make_tip("flat_punch", radius=radius)))
    expect("sphere", sphere["modulus_GPa"] / 70, near=1, tolerance=1e-3)
    expect("punch", punch["modulus_GPa"] / 70, near=1, tolerance=1e-6)
    assert sphere["warnings"] == punch["warnings"] == ""


def test_datum_of_an_open_package(expect):
    """Copper by a Berkovich tip with an area function: the data and results with which the package micromechanics tests itself.

    Those results belong to the depth 111.172 nm, which that test uses; 111.901 nm stands in a remark beside it.
    """
    tip = tips.tip_of_function([32.9049, -6418.303798, 288484.8518, -989287.0625, 103588.5588, 675977.3345])
    _, area, hardness, reduced = oliver_pharr.contact(tip, 0.111172457420282, 0.491297865144331, 159.111704268288, tip.epsilon, tip.beta(0.35))
    constants = Constants(tip_modulus=1141, tip_poisson=0.07)
    for name, value, told in (("area, um2", area, 0.598047490), ("hardness, GPa", hardness, 0.8215030968), ("reduced modulus, GPa", reduced, 182.3388587),
                              ("modulus, GPa", oliver_pharr.specimen_modulus(reduced, 0.35, constants), 190.2577293)):
        expect(name, value / told - 1, near=0, tolerance=1e-6)


# ---- tips ----

def test_areas(expect):
    depths = np.array([0.1, 2.0])
    for kind, factor in (("berkovich", 24.494), ("vickers", 24.504), ("cube_corner", 2.598)):
        expect(kind, np.max(np.abs(tips.make_tip(kind).area(depths) / depths**2 - factor)), at_most=1e-3)
    expect("cone", CONE.area(1.0), near=24.50, tolerance=0.01)
    expect("rounded cone near its end", tips.make_tip("cone", half_angle=70.3, tip_radius=2).area(1e-6) / (4e-6 * math.pi), near=1, tolerance=1e-5)
    rounded = tips.make_tip("pyramid", half_angle=60, faces=300, tip_radius=1).area
    expect("rounded pyramid of many faces: ball", rounded(0.1) / (math.pi * (1 - 0.9**2)), near=1, tolerance=1e-3)
    expect("rounded pyramid of many faces: cone", rounded(3.0) / (math.pi * (2 * math.sqrt(3) + 2) ** 2), near=1, tolerance=1e-3)
    expect("depth of an area", tips.depth_of(CONE, CONE.area(0.7), 2), near=0.7, tolerance=1e-4)


def ball_and_cone(h, degrees, radius):
    """The radius of a section of a ball with a tangent cone, by construction: the tangent point is where the ball's slope is the cone's."""
    angle = math.radians(degrees)
    touch, across = radius - radius * math.sin(angle), radius * math.cos(angle)
    return math.sqrt(radius**2 - (radius - h) ** 2) if h < touch else across + (h - touch) * math.tan(angle)


@pytest.mark.parametrize("degrees, radius", [(30, 1.0), (60, 200.0), (70.3, 0.1), (45, 5.0)])
def test_rounded_cone_is_a_ball_with_a_tangent_cone(expect, degrees, radius):
    """The conosphere of a laboratory; Rockwell's tip has 60 degrees and 200 um. One of many faces is the same."""
    heights = radius * np.array([0, 0.01, 0.05, 0.1, 0.3, 0.5, 1, 3, 20])
    area = tips.make_tip("cone", half_angle=degrees, tip_radius=radius).area(heights)
    exact = np.array([math.pi * ball_and_cone(h, degrees, radius) ** 2 for h in heights])
    expect("area", np.max(np.abs(area[1:] / exact[1:] - 1)), at_most=1e-12)
    pyramid = tips.make_tip("pyramid", half_angle=degrees, faces=400, tip_radius=radius).area(heights)
    expect("pyramid of 400 faces", np.max(np.abs(pyramid[1:] / exact[1:] - 1)), at_most=1e-3)
    assert area[0] == pyramid[0] == 0 == tips.make_tip("cone", half_angle=degrees, tip_radius=radius).area(-radius)
    end = tips.ball_height(degrees, radius) * (1 + np.array([-1e-9, 1e-9]))
    expect("step from the ball to the flank", np.ptp(tips.section_radius(end, degrees, radius)) / radius, at_most=1e-8)


def test_contact_on_the_ball_of_a_cone():
    """For a tip of 30 degrees the beta of the cone is 1.39, and the contact is that of a ball."""
    tip = tips.make_tip("cone", half_angle=30, tip_radius=1)
    rows = [oliver_pharr.analyse(curve(*metal(top=top, final=0.84 * top), tip=tip), Constants(beta=beta))[0] for top, beta in ((0.3, None), (0.3, 1), (1.0, None))]
    assert ["on the ball" in row["warnings"] for row in rows] == [True, False, False]


def test_pile_up(expect):
    """A true area twice that of the cone at the largest depth: the rim is higher than the surface by (sqrt 2 - 1) of the depth."""
    depth, load = metal()
    [row] = oliver_pharr.analyse(curve(depth, load, area=2 * CONE.area(np.maximum(depth, 0))))
    expect("pile-up", row["pile_up_um"], near=0.5 * (math.sqrt(2) - 1), tolerance=1e-3)
    expect("load over true area", row["true_hardness_GPa"], near=10 / (2 * math.pi * TAN**2 / 4), tolerance=1e-6)
    assert "true contact area" in row["warnings"]


def test_unloading_that_ends_above_the_surface(expect):
    """One that is softer than any contact is told. Where it is a wave on that of an elastic sphere, as on few cells, the stiffness
    is right within 5 %, where the power law by itself is 9 % off."""
    [row] = oliver_pharr.analyse(curve(*metal(top=0.1, final=-0.4)))
    assert row["final_depth_um"] == 0 and "um above the surface" in row["warnings"] and "differs from its fit" in row["warnings"]
    depth = np.append(np.linspace(0, 0.03, 200), np.linspace(0.03, 0, 200)[1:])
    load = depth**1.5 * (1 + 0.006 * np.cos(2 * math.pi * (depth - 0.018) / 0.012))
    [row] = oliver_pharr.analyse(curve(depth, load))
    expect("stiffness", row["stiffness_mN_per_um"] / (1.5 * 0.03**0.5), near=1, tolerance=0.05)
    expect("final depth", row["final_depth_um"], near=0, tolerance=1e-12)


def test_area_function_without_area():
    """It is not the contact depth that is wrong."""
    for coefficient in (0, -24.5):
        [row] = oliver_pharr.analyse(curve(*metal(), tip=tips.tip_of_function([coefficient])))
        assert "area of the tip" in row["warnings"] and "below zero" not in row["warnings"]


def test_work_before_the_curve(expect):
    """A curve from a quarter of the depth on lacks a 64th of its work; one from the surface on, with few rows, lacks none."""
    depth, load = metal()
    [row] = oliver_pharr.analyse(curve(depth[100:], load[100:]))
    told = re.search(r"the curve begins at 0.125 um and 0.6.* mN: up to (\S+) % of the work", row["warnings"])
    expect("work that is missing, %", float(told[1]), near=100 / 64, tolerance=0.8)
    expect("work that is there", row["total_work_nJ"] / (10 * 0.5 / 3), near=63 / 64, tolerance=1e-3)
    rows = np.append(np.arange(10, 400, 20), np.arange(400, 799))
    assert oliver_pharr.analyse(curve(depth[rows], load[rows]))[0]["warnings"] == ""


def test_curves_that_cannot_be(expect):
    """Rows in reverse order, and a zero of depths long before the tip touches."""
    depth, load = metal(lowest=0.01)
    [row] = oliver_pharr.analyse(curve(depth[::-1], load[::-1]))
    assert row["plastic_share"] < -0.05 and "are the rows in order" in row["warnings"]
    before = np.linspace(0, 0.2, 100)[:-1]
    [row] = oliver_pharr.analyse(curve(np.append(before, 0.2 + depth), np.append(0 * before, load)))
    told = re.search(r"there is no load up to (\S+) um, (\d+) % of the depth", row["warnings"])
    expect("where the tip touches, um", float(told[1]), near=0.2 + 0.5 * math.sqrt(0.005), tolerance=0.002)
    [row] = oliver_pharr.analyse(curve(np.append(before - 0.2, depth), np.append(0 * before, load)))
    assert "there is no load" not in row["warnings"]


# ---- cycles and holds ----

def cycles_of(loads, lowest=0.1):
    """A test with unloadings to a tenth, or another share, from several loads; all unloadings are alike but for their size."""
    parts, last = [], 0.0
    for load in loads:
        top = 0.5 * math.sqrt(load / 10)
        depth, force = metal(top, load, 0.84 * top, lowest=lowest, first=last)
        up = depth[:400] >= last
        parts.append((depth[:400][up], force[:400][up]))
        parts.append((depth[400:], force[400:]))
        parts.append((depth[400:][::-1], force[400:][::-1]))
        last = top
    return (np.concatenate(each) for each in zip(*parts[:-1]))


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
    """The tip creeps on; a nose is told of."""
    depth, load = metal(rows=300)
    creep = 0.5 - 0.02 * np.exp(-np.linspace(0, 6, 200))
    whole = np.concatenate([0.48 * depth[:300] / 0.5, creep, depth[300:]]), np.concatenate([load[:300], np.full(200, 10.0), load[300:]])
    [row] = oliver_pharr.analyse(curve(*whole))
    expect("stiffness", row["stiffness_mN_per_um"] / STIFFNESS - 1, near=0, tolerance=0.01)
    nose = np.linspace(10, 9, 50)
    [row] = oliver_pharr.analyse(curve(np.concatenate([depth[:300], 0.5 + np.linspace(0, 0.005, 50), depth[300:]]),
                                       np.concatenate([load[:300], nose, 0.9 * load[300:]])))
    assert "nose" in row["warnings"]


# ---- runs ----

OPTIONS = {"-geometry": "plane_strain", "-domain_lower": "0,0", "-domain_upper": "1e-5,1e-5", "-cell_size": "1e-7", "-boundary_x_lower": "symmetry",
           "-boundary_x_upper": "free", "-indenter": "wedge", "-indenter_half_angle": "70.3", "-indenter_tip": "0,8e-06", "-m_poissons_ratio": "0.3"}
CONE_OPTIONS = {**OPTIONS, "-geometry": "axisymmetric", "-indenter": "cone", "-indenter_tip_radius": "0"}
QUARTER = {**CONE_OPTIONS, "-geometry": "3d", "-domain_lower": "0,0,0", "-domain_upper": "1e-5,1e-5,1e-5", "-boundary_y_lower": "symmetry",
           "-boundary_y_upper": "symmetry", "-indenter": "vickers", "-indenter_tip": "0,0,8e-06"}
HALF = {**QUARTER, "-domain_lower": "-1e-5,0,0", "-indenter": "berkovich"}


def write_run(folder, options, repeated=False, slow=False):
    """A result folder with a history of metal(), whose loads are means over the intervals; slow: a fifth of them is inertia and damping."""
    folder.mkdir()
    depth, load = metal(rows=2001)
    depth, load = 1e-6 * depth[::2], 1e-3 * np.append(0, load[1::2])
    columns = dict.fromkeys([*HISTORY, "contact_area"], np.zeros(len(depth))) | {"step": np.arange(len(depth)), "time": 1e-9 * np.arange(len(depth)),
                                                                                 "depth": depth, "load": load}
    columns["contact_area"] = np.full(len(depth), 3e-12)
    columns |= {"load_quasi_static": load, "load": 1.25 * load} if slow else {}
    table = np.column_stack(list(columns.values()))
    table = np.insert(table, 100, table[80:100], axis=0) if repeated else table
    np.savetxt(folder / "history.csv", table, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    (folder / "summary.json").write_text(json.dumps({"case": "made", "levels": []} | ({"options": options} if options else {})))
    return folder


@pytest.mark.parametrize("options, parts, tip", [(OPTIONS, 2, None), (CONE_OPTIONS, 1, "cone"), (QUARTER, 4, "vickers"), (HALF, 2, "berkovich"),
                                                 ({**OPTIONS, "-indenter_tip": "1e-6,8e-06"}, 1, None), (None, 1, None)],
                         ids=["half in plane strain", "axisymmetric", "quarter", "half", "away from the side", "not known"])
def test_parts_of_a_tip(tmp_path, options, parts, tip):
    read = load_depth.read_run(write_run(tmp_path / "run", options))
    assert abs(read.load.max() / parts - 10) < 0.01 and abs(read.area[-1] - 3 * parts) < 1e-12
    assert (read.tip and read.tip.name) == tip and read.plane == (options is not None and options["-geometry"] == "plane_strain")
    assert any("equal parts" in note for note in read.notes) == (parts > 1)


@pytest.mark.parametrize("more, told", [({}, False), ({"-gravity": "0,0"}, False), ({"-gravity": "0,-9.81"}, True), ({"-loads": "p"}, True)])
def test_loads_that_move_the_surface_are_noted(tmp_path, more, told):
    read = load_depth.read_run(write_run(tmp_path / "run", {**CONE_OPTIONS, **more}))
    assert any("move the surface" in note for note in read.notes) == told


def test_contact_above_the_surface_under_the_tip():
    """As on the rim of a hole, where hardness and modulus came out as NaN."""
    depth, load = metal()
    with pytest.raises(ResultError, match="the contact is above that"):
        oliver_pharr.analyse(curve(np.asarray(depth) - 2 * np.max(depth), load))


def test_run_to_files(tmp_path, capsys, expect):
    """Rows that a restart wrote twice do no harm; the files say the same."""
    folder = write_run(tmp_path / "run", CONE_OPTIONS, repeated=True)
    main([str(folder)])
    printed = capsys.readouterr().out
    [described] = json.loads((folder / "indentation.json").read_text())["curves"]
    [cycle], [row] = described["cycles"], list(csv.DictReader(open(folder / "indentation.csv")))
    assert described["tip"] == "cone" and float(row["hardness_GPa"]) == cycle["hardness_GPa"] and "beta" in printed
    expect("stiffness", cycle["stiffness_mN_per_um"] / STIFFNESS - 1, near=0, tolerance=2e-3)
    expect("beta", cycle["beta"], near=1.067, tolerance=5e-4)
    assert np.ptp(plt.imread(folder / "indentation.png")) > 0.5


def test_expected_errors(tmp_path, capsys):
    """Of runs, by how many cells are in contact; measured curves have none."""
    [row] = oliver_pharr.analyse(curve(*metal(), is_run=True))
    assert row["cells"] == 8 and row["expected_error"]["hardness_GPa"] == pytest.approx(0.7 / 8) and row["expected_error"]["true_area_um2"] == pytest.approx(1.3 / 8)
    assert row["expected_error"]["modulus_GPa"] == pytest.approx(0.7 / 8 + 1.09 / 20) and set(row["expected_error"]) < set(row)
    [measured] = oliver_pharr.analyse(curve(*metal()))
    assert math.isnan(measured["cells"]) and measured["expected_error"] is None and list(measured) == list(oliver_pharr.COLUMNS)
    folder = write_run(tmp_path / "run", CONE_OPTIONS)
    table = np.genfromtxt(folder / "history.csv", delimiter=",", names=True)
    half = np.where(table["depth"] > 0, 6e-7, 0)
    lines = (folder / "history.csv").read_text().splitlines()
    place = lines[0].split(",").index("contact_half_width")
    lines[1:] = [",".join([*line.split(",")[:place], repr(float(width)), *line.split(",")[place + 1:]]) for line, width in zip(lines[1:], half)]
    (folder / "history.csv").write_text("\n".join(lines) + "\n")
    summary = json.loads((folder / "summary.json").read_text()) | {"levels": [{"lower": [0, 0], "upper": [1, 1], "cell_size": 4e-7}, {"lower": [0, 0], "upper": [1, 1], "cell_size": 1e-7}]}
    (folder / "summary.json").write_text(json.dumps(summary))
    main([str(folder)])
    printed = capsys.readouterr().out
    [cycle] = json.loads((folder / "indentation.json").read_text())["curves"][0]["cycles"]
    [written] = csv.DictReader(open(folder / "indentation.csv"))
    assert cycle["cells"] == pytest.approx(6) and cycle["expected_error"]["load_mN"] == pytest.approx(0.7 / 6)
    assert cycle["expected_error"]["modulus_GPa"] == pytest.approx(0.7 / 6 + 1.09 * 6e-7 / 1e-5)  # the tip is on the axis
    assert re.search(r"^  hardness  .* GPa \+- 12 %$", printed, re.M) and float(written["expected_error_true_hardness_GPa"]) == pytest.approx(1.3 / 6)


def test_slow_run(tmp_path, expect):
    """Of a run with -quasi_static the load is taken without inertia and damping."""
    [row] = oliver_pharr.analyse(load_depth.read_run(write_run(tmp_path / "run", CONE_OPTIONS, slow=True)))
    expect("load", row["load_mN"], near=10, tolerance=0.02)


def test_plane_strain_has_only_the_mean_pressure(tmp_path, capsys):
    folder = write_run(tmp_path / "run", OPTIONS)
    main([str(folder)])
    [cycle] = json.loads((folder / "indentation.json").read_text())["curves"][0]["cycles"]
    assert cycle["hardness_GPa"] is None and cycle["modulus_GPa"] is None and abs(cycle["true_hardness_GPa"] - 20 / 6) < 0.01
    assert "plane strain" in capsys.readouterr().out


# ---- refusals ----

GOOD = text_of(*metal())
def refusal(*words):
    with pytest.raises(SystemExit) as caught:
        main([str(word) for word in words])
    assert re.fullmatch(r"error: [^\n]+", str(caught.value.code)), caught.value.code
    return caught.value.code


WORDS = {
    "no curve": [], "no such file": ["none.csv"], "tip not known": ["m.csv"], "cone without angle": ["m.csv", "--tip", "cone"],
    "sphere without radius": ["m.csv", "--tip", "sphere"], "unknown tip": ["m.csv", "--tip", "knoop"],
    "two tips": ["m.csv", "--tip", "vickers", "--area-function", "24.5"],
    "window upside down": ["m.csv", "--tip", "vickers", "--window", "0.9,0.5"], "empty window": ["m.csv", "--tip", "vickers", "--window", "0.96,0.961"],
    "unit": ["m.csv", "--tip", "vickers", "--depth", "depth:inch"], "no unit": ["m.csv", "--tip", "vickers", "--load", "load"],
    "Poisson's ratio": ["m.csv", "--tip", "vickers", "--poisson", "0.7"], "beta": ["m.csv", "--tip", "vickers", "--beta", "0"],
    "drift without time": ["m.csv", "--tip", "vickers", "--drift", "0.1"], "area function": ["m.csv", "--area-function", "24.5,x"],
    "out": ["m.csv", "--tip", "vickers", "--out", "/dev/null/none"],
    "modulus in Pa": ["m.csv", "--tip", "vickers", "--tip-elastic", "1141e9,0.07"],
    "angle of another tip": ["m.csv", "--tip", "berkovich", "--half-angle", "30"],
    "radius of another tip": ["m.csv", "--tip", "berkovich", "--radius", "5"],
    "faces of another tip": ["m.csv", "--tip", "vickers", "--faces", "3"],
    "size without a tip": ["m.csv", "--area-function", "24.5", "--radius", "5"],
    "rounded sphere": ["m.csv", "--tip", "sphere", "--radius", "5", "--tip-radius", "0.1"],
    "tip radius in m": ["m.csv", "--tip", "vickers", "--tip-radius", "1e-7"],
    "radius in m": ["m.csv", "--tip", "sphere", "--radius", "5e-6"],
}


@pytest.mark.parametrize("name", WORDS)
def test_words(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.csv").write_text(GOOD)
    refusal(*WORDS[name])


@pytest.mark.parametrize("given, line", [
    ({"poisson": 33}, "poisson=33: must be in"), ({"poisson": 0.7}, "poisson=0.7"), ({"poisson": 1.0}, "poisson=1.0"),
    ({"poisson": "0.3"}, "not as a text"), ({"epsilon": -1}, "epsilon=-1"), ({"beta": math.nan}, "beta=nan"),
    ({"window": (0.98, 0.2)}, "LOW < HIGH"), ({"window": 0.5}, "LOW < HIGH"),
    ({"tip_modulus": 1141e9}, "1141 GPa are 1141, not 1141e9"),
    ({"tip_poisson": 0.6}, "tip_poisson=0.6"), ({"foo": 1}, "foo: must be one of window, epsilon")])
def test_constants_from_python(tmp_path, given, line):
    """Python takes no constants that the command refuses."""
    run = mlgimp.read(write_run(tmp_path / "run", CONE_OPTIONS))
    with pytest.raises(mlgimp.Error, match=line):
        run.oliver_pharr(**given)
    good = {"poisson": np.float32(0.3), "window": "0.4,0.9", "tip_modulus": np.array(1141), "tip_poisson": 0.07, "epsilon": None}
    assert math.isfinite(run.oliver_pharr(**good)[0]["modulus_GPa"])


def test_folders(tmp_path):
    assert "history.csv" in refusal(tmp_path)
    (tmp_path / "history.csv").write_text(",".join(HISTORY) + "\n")
    assert "history.csv has 0 rows" in refusal(tmp_path)
    folder = write_run(tmp_path / "run", {**CONE_OPTIONS, "-indenter_half_angle": "steep"})
    assert "summary.json" in refusal(folder)
    (folder / "summary.json").unlink()
    assert "--tip" in refusal(folder)
