"""Checks uncertainties by Monte Carlo: intervals that hold the truth, sources one by one against the law of propagation, cells, refusals."""
import csv
import json
import math
import time

import numpy as np
import pytest

from made_curves import CONE_OPTIONS, GOOD, STIFFNESS, curve, main, metal, refusal, write_run
from mlgimp import oliver_pharr, tips, uncertainty, zeros
from mlgimp.errors import Error
from mlgimp.uncertainty import QUANTITIES, Inputs

pytestmark = pytest.mark.fast

TIP = tips.tip_of_function([24.5])
STATED = Inputs(zero_nm=3, compliance_nm_per_mN=0.2, area_percent=2, poisson=0.02, depth_nm=0.2, load_uN=10)


def analysed(test):
    """The dict of results and the Unloading of a curve with one unloading."""
    [(row, fit)] = oliver_pharr.analysed(test)
    return row, fit


def found_of(test, inputs=STATED, draws=200, **more):
    return uncertainty.uncertainty(test, *analysed(test), inputs=inputs, draws=draws, **more)


def measured(random, stated=STATED, rows=300):
    """A curve of a body, instrument and tip whose true values are drawn from the stated uncertainties, and the true QUANTITIES."""
    depth, load = metal(rows=rows, lowest=0.1)
    area = 24.5 * (0.5 - 0.75 * 10 / STIFFNESS) ** 2 * (1 + 0.01 * stated.area_percent * random.normal())
    reduced = math.sqrt(math.pi / area) * STIFFNESS / 2
    truth = 10 / area, reduced, reduced * (1 - (0.3 + stated.poisson * random.normal()) ** 2)
    seen = depth + 1e-3 * (stated.compliance_nm_per_mN * load * random.normal() + stated.zero_nm * random.normal() + stated.depth_nm * random.normal(size=len(depth)))
    return curve(seen, load + 1e-3 * stated.load_uN * random.normal(size=len(load)), tip=TIP), truth


def test_intervals_hold_the_truth(expect):
    """Of 100 tests, 95 % intervals hold the truth in 90 to 99: with a probability of .95 they are 91 to 99 in 98 of 100 such hundreds."""
    random = np.random.default_rng(1)
    held = []
    for seed in range(100):
        test, truth = measured(random)
        found = found_of(test, draws=1000, seed=seed)
        held.append([found.lower[name] <= value <= found.upper[name] for name, value in zip(QUANTITIES, truth)])
    for name, count in zip(QUANTITIES, np.sum(held, axis=0)):
        expect(f"intervals of {name} that hold the truth", int(count), at_least=90)
        expect(f"intervals of {name} that hold the truth", int(count), at_most=99)


def test_sources_one_by_one(expect):
    """First order: u(H)/H is 2 u(h)/h_c for the contact point and u(A)/A for the area; half of each, and
    2 nu u(nu)/(1 - nu^2) for E; a compliance C changes 1/S by C. Of 20000 draws a standard deviation is known to 0.5 %."""
    test = curve(*metal(lowest=0.1), tip=TIP)
    row, fit = analysed(test)
    inputs = uncertainty.standard(test, fit, STATED._replace(depth_nm=0.0, load_uN=0.0))
    random = np.random.default_rng(1)
    draws = random.normal(size=20000)
    nominal = {"depth": fit.depth, "load": fit.load, "stiffness": fit.stiffness, "exponent": fit.exponent, "zero": 0.0, "compliance": 0.0, "area": 0.0,
               "poisson": 0.3}
    deep, slope = row["contact_depth_um"], 1e-3 * inputs.compliance_nm_per_mN
    rise = -slope * (1 - 0.75) * fit.load / deep  # of h_c by compliance: -C P from the depth, and 0.75 P C less for the surface beside it
    expected = {"zero": (1e-3 * inputs.zero_nm, 2e-3 * inputs.zero_nm / deep, 1e-3 * inputs.zero_nm / deep),
                "area": (0.01 * inputs.area_percent, 0.01 * inputs.area_percent, 0.005 * inputs.area_percent),
                "compliance": (slope, abs(2 * rise), abs(slope * STIFFNESS - rise)), "poisson": (inputs.poisson, 0.0, 0.0)}
    for name, (size, *shares) in expected.items():
        values = uncertainty.figures(test, oliver_pharr.Constants(), **{**nominal, name: nominal[name] + size * draws})
        for quantity, share, own in zip(QUANTITIES, [*shares, math.hypot(shares[1], 2 * 0.3 * inputs.poisson / 0.91 if name == "poisson" else 0)], values):
            expect(f"{name}, {quantity}", float(np.std(own)) / row[quantity], near=share, tolerance=0.03 * share + 1e-9)


@pytest.mark.parametrize("constants", [{"iso": True}, {"epsilon": 0.9}, {"beta": 1.1}, {"iso": True, "epsilon": 0.7, "beta": 1.02}, {}],
                         ids=lambda given: " ".join(given) or "by default")
def test_draws_are_by_the_same_conventions(expect, constants):
    """Without any noise each draw is the figure itself, by the norm, too; with little the middle of the interval is."""
    chosen = oliver_pharr.checked_constants(**constants)
    test = curve(*metal(lowest=0.1), tip=tips.make_tip("berkovich"))
    (row, fit), = oliver_pharr.analysed(test, chosen)
    nothing = Inputs(**dict.fromkeys(Inputs._fields, 0.0))
    for inputs, tolerance in ((nothing, 1e-3), (STATED, 0.02)):
        found = uncertainty.uncertainty(test, row, fit, chosen, inputs, draws=1000)
        for name in QUANTITIES:
            expect(f"middle of the interval of {name}", (found.lower[name] + found.upper[name]) / 2 / row[name], near=1, tolerance=tolerance)
            expect.that(f"interval of {name} holds it", found.lower[name] <= row[name] * (1 + 1e-6) and row[name] <= found.upper[name] * (1 + 1e-6), f"{row[name]}")


@pytest.mark.parametrize("final, exponent", [(0.42, 1.4), (0.4, 1.0), (-0.02, 1.6)], ids=["power law", "limit of m", "hf held at zero"])
def test_noise_is_what_curves_have(expect, final, exponent):
    """The spread of stiffnesses that is drawn is that of fits to curves with other noise: of 80 it is known to 8 %."""
    random = np.random.default_rng(2)

    def noisy():
        depth, load = metal(rows=300, lowest=0.1, final=final, exponent=exponent)
        return curve(depth + 2e-4 * random.normal(size=len(depth)), load + 0.01 * random.normal(size=len(load)), tip=TIP)
    fits = [analysed(noisy())[1] for _ in range(80)]
    test = curve(*metal(rows=300, lowest=0.1, final=final, exponent=exponent), tip=TIP)
    *_, drawn = uncertainty.noisy_starts(test, analysed(test)[1], STATED, random, 20000)
    share = np.std(drawn) / np.std([fit.stiffness for fit in fits])
    expect("standard deviation of the stiffness", share, at_least=0.75)
    expect("standard deviation of the stiffness", share, at_most=1.25 if exponent > 1 else 2.5)  # half of the fits have m at its limit


def test_inputs_by_default():
    """Noise is found in the curve; the contact point where the load is three times its noise; a run knows its own."""
    random = np.random.default_rng(3)
    test, _ = measured(random, STATED._replace(zero_nm=0.0, compliance_nm_per_mN=0.0))
    inputs = uncertainty.standard(test, analysed(test)[1])
    assert inputs.depth_nm == pytest.approx(0.2, rel=0.2) and inputs.compliance_nm_per_mN == uncertainty.FRAME and inputs.area_percent == uncertainty.AREA
    assert inputs.load_uN == pytest.approx(10, rel=0.3)
    assert inputs.zero_nm == pytest.approx(1e3 * 0.5 * math.sqrt(3e-3 * inputs.load_uN / 10) / math.sqrt(3), rel=0.3)
    run = curve(*metal(lowest=0.1), is_run=True)
    assert uncertainty.standard(run, analysed(run)[1])[:4] == (0, 0, 0, 0)


def test_cells_of_two_runs(expect):
    """An error of first order: 4 % on 4 cells and 2 % on 8 differ by 2 %, so that the finer has 2 % left, the coarser 4."""
    rows = [dict.fromkeys(QUANTITIES, 1 + 0.16 / cells) | {"cells": cells, "depth_um": 0.2} for cells in (4, 8)]
    coarse, fine = (uncertainty.errors_of_cells(*pair)[0][0] for pair in (rows, rows[::-1]))
    expect("the coarser", float(coarse), near=0.04, tolerance=2e-3)
    expect("the finer", float(fine), near=0.02, tolerance=1e-3)
    with pytest.raises(Error, match="1.2 times as many cells"):
        uncertainty.errors_of_cells(rows[0], rows[0] | {"cells": 4.5})
    with pytest.raises(Error, match="must be of the same test; it is 0.3 um deep, not 0.2 um"):
        uncertainty.errors_of_cells(rows[0], rows[1] | {"depth_um": 0.3})
    run = curve(*metal(lowest=0.1), is_run=True)
    found = found_of(run, Inputs(), draws=5000)
    share = next(share for share in found.shares if share.source == "cells")
    expect("even between the limits of the expected error", share.deviation["hardness_GPa"] / found.values["hardness_GPa"], near=0.3 / 8 / math.sqrt(3), tolerance=1e-3)


def test_the_block_makes_moduli_smaller_alone():
    """A block of 20 half widths: moduli are too large by 1.09/20 at most, hardnesses are not; what is left out is said with the figures of the
    true area."""
    depth, load = metal(lowest=0.1)
    run = curve(depth, load, np.full(len(depth), 6.0), is_run=True)
    found = found_of(run, Inputs(depth_nm=0, load_uN=0), draws=5000)
    share = next(share for share in found.shares if share.source == "block")
    assert share.deviation["hardness_GPa"] < 1e-12
    assert share.deviation["modulus_GPa"] / found.values["modulus_GPa"] == pytest.approx(1.09 / 20 / math.sqrt(12), rel=0.03)
    assert found.values["modulus_GPa"] - found.lower["modulus_GPa"] > 1.5 * (found.upper["modulus_GPa"] - found.values["modulus_GPa"])
    [sentence] = found.left_out
    assert "the true contact area of this run is" in sentence and f"hardness {10 / 6:.4g} GPa" in sentence
    assert f"  not included: {sentence}" in list(uncertainty.lines_of(found))
    assert "an unloading does not show them" in found_of(curve(depth, load, tip=TIP)).left_out[0]


def test_a_zero_that_was_found_has_its_own_error():
    random = np.random.default_rng(1)
    test, _ = measured(random)
    plain = uncertainty.standard(test, analysed(test)[1]).zero_nm
    found = zeros.without_zero_depth(test._replace(depth=test.depth + 0.1), "auto")
    own = uncertainty.standard(found, analysed(found)[1]).zero_nm
    assert own == pytest.approx(1e3 * zeros.by_power(test).error, rel=0.05) and own < plain / 3
    assert "of the zero that was found (--u-zero)" in " ".join(share.input for share in found_of(found, Inputs()).shares)
    assert "that was found" not in " ".join(share.input for share in found_of(found).shares)


def test_the_same_seed_gives_the_same(expect):
    test, _ = measured(np.random.default_rng(4))
    begun = time.monotonic()
    one, same, other = (found_of(test, draws=1000, seed=seed) for seed in (1, 1, 2))
    assert one.lower == same.lower and one.deviation == same.deviation and one.lower != other.lower
    expect("seconds of 1000 draws", (time.monotonic() - begun) / 3, at_most=10)
    total = one.deviation["modulus_GPa"] ** 2
    expect("squares of the shares", sum(share.deviation["modulus_GPa"] ** 2 for share in one.shares) / total, near=1, tolerance=0.15)


def test_command(tmp_path, capsys):
    (tmp_path / "m.csv").write_text(GOOD)
    main([str(tmp_path / "m.csv"), "--area-function", "24.5", "--poisson", "0.3", "--uncertainty", "200", "--u-area", "3", "--u-zero", "1"])
    printed = capsys.readouterr().out
    rows = list(csv.DictReader(open(tmp_path / "uncertainty.csv")))
    assert [row["source"] for row in rows] == ["noise", "window", "contact point", "compliance", "area", "Poisson's ratio", "total"] and "u(H)" in printed
    assert float(rows[4]["u_hardness_GPa"]) / float(rows[4]["value_hardness_GPa"]) == pytest.approx(0.03, rel=0.2) and rows[4]["lower_hardness_GPa"] == ""
    [described] = json.loads((tmp_path / "indentation.json").read_text())["curves"]
    assert described["uncertainty"]["lower_95"]["hardness_GPa"] == pytest.approx(float(rows[-1]["lower_hardness_GPa"]), rel=1e-5)
    main([str(tmp_path / "m.csv"), "--area-function", "24.5", "--uncertainty", "200"])  # without a Poisson's ratio
    assert "u(E)" not in capsys.readouterr().out
    main([str(write_run(tmp_path / "run", CONE_OPTIONS)), "--uncertainty", "200"])
    assert "contact point         0.00 %" in capsys.readouterr().out


@pytest.mark.parametrize("words, line", [
    (["--u-area", "2"], "--u-area: needs --uncertainty"), (["--uncertainty", "10"], "a whole number in [100, 100000]"),
    (["--uncertainty", "--u-zero", "-1"], "a number >= 0"), (["--uncertainty", "--u-zero", "nan"], "a number >= 0"),
    (["--other-cells", "run"], "--other-cells: needs --uncertainty"), (["--uncertainty", "--seed", "-1"], "--seed -1"),
    (["--uncertainty", "--u-zero", "1e6"], "there is no contact"), (["--uncertainty", "--other-cells", "run"], "must stand beside a run")])
def test_refusals(tmp_path, words, line):
    (tmp_path / "m.csv").write_text(GOOD)
    assert line in refusal(tmp_path / "m.csv", "--area-function", "24.5", *words)
