"""Checks the pictures that the analysis of indentation tests draws."""
import json

import numpy as np
import pytest

from made_curves import CONE_OPTIONS, cycles_of, main, metal, text_of, write_run

pytestmark = pytest.mark.fast


@pytest.fixture
def drawn(monkeypatch):
    """The figures that the command draws."""
    figures = []
    monkeypatch.setitem(main.__wrapped__.__globals__, "save", lambda figure, path: figures.append(figure))
    return figures


def dots(axes):
    """(x, y) of the markers of axes."""
    return [tuple(np.ravel(line.get_data())) for line in axes.lines]


@pytest.mark.parametrize("names", [("run", "m.csv"), ("run", *(f"measured_specimen_{k}.csv" for k in range(4)))])
def test_picture_of_curves_with_an_unloading_each(tmp_path, drawn, names):
    """Hardness and modulus stand in panels of their own, by curve: by name where there is room, else by number."""
    write_run(tmp_path / "run", CONE_OPTIONS)
    for name in names[1:]:
        (tmp_path / name).write_text(text_of(*metal()))
    main([str(tmp_path / name) for name in names])
    _, hardness, modulus = drawn[0].axes
    cycles = [each["cycles"][0] for each in json.loads((tmp_path / "run" / "indentation.json").read_text())["curves"]]
    for axes, name in ((hardness, "hardness_GPa"), (modulus, "modulus_GPa")):
        assert dots(axes) == [(k, cycle[name]) for k, cycle in enumerate(cycles, start=1)]
        assert axes.get_ylabel() == name.replace("_GPa", " (GPa)")
    legend = [text.get_text() for text in drawn[0].axes[0].get_legend().get_texts()]
    if len(names) == 2:
        assert [label.get_text() for label in modulus.get_xticklabels()] == list(names) and set(names) < set(legend)
    else:
        assert modulus.get_xlabel() == "curve" and "2: measured_specimen_0.csv" in legend


def test_intervals_of_uncertainty_are_drawn(tmp_path, drawn):
    """A line beside the largest unloading, from the lower to the upper end."""
    (tmp_path / "a.csv").write_text(text_of(*cycles_of((1, 2, 5))))
    main([str(tmp_path / "a.csv"), "--tip", "vickers", "--poisson", "0.3", "--uncertainty", "200"])
    _, hardness, modulus = drawn[0].axes
    known = json.loads((tmp_path / "indentation.json").read_text())["curves"][0]["uncertainty"]
    for axes, name in ((hardness, "hardness_GPa"), (modulus, "modulus_GPa")):
        [[(low, high)]] = [[segment[:, 1] for segment in each.get_segments()] for each in axes.collections]
        assert (low, high) == pytest.approx((known["lower_95"][name], known["upper_95"][name]))


def test_picture_over_depth(tmp_path, drawn):
    """Where a curve has several unloadings; one that cannot be fitted, or another curve that has no figures, does not stop it."""
    (tmp_path / "a.csv").write_text(text_of(*cycles_of((1, 2, 5))))
    (tmp_path / "b.csv").write_text(text_of(*(each[:300] for each in metal())))
    with pytest.raises(SystemExit):
        main([str(tmp_path / "a.csv"), str(tmp_path / "b.csv"), "--tip", "vickers"])
    _, hardness, modulus = drawn[0].axes
    [line] = hardness.lines
    assert len(line.get_xdata()) == 3 and line.get_xdata()[-1] == pytest.approx(0.5 * 0.5**0.5) and modulus.get_xlabel() == "depth (µm)"
