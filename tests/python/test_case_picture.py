"""Pictures of cases before they run: what is read of a case, and the width of each indenter."""
import math

import figures
import numpy as np
import pytest

import harness
from mlgimp import case_picture, outlines, pictures, tips
from mlgimp.errors import Error

pytestmark = pytest.mark.fast


@pytest.mark.parametrize("options, left, right", [
    ({"-indenter": "wedge", "-indenter_half_angle": "60"}, math.sqrt(3), math.sqrt(3)),
    ({"-indenter": "sphere", "-indenter_radius": "2"}, math.sqrt(3), math.sqrt(3)),
    ({"-indenter": "cylinder", "-indenter_radius": "0.5"}, 0.5, 0.5),  # above the middle the shaft
    ({"-indenter": "flat_punch", "-indenter_width": "4", "-geometry": "plane_strain"}, 2, 2),
    ({"-indenter": "flat_punch", "-indenter_radius": "4", "-geometry": "axisymmetric"}, 4, 4),
    ({"-indenter": "berkovich"}, 2 * math.tan(math.radians(65.27)), math.tan(math.radians(65.27))),  # an edge and a face
    ({"-indenter": "vickers", "-indenter_turn": "45"}, *[math.sqrt(2) * math.tan(math.radians(68))] * 2),  # edges
])
def test_width_of_indenters(options, left, right):
    found = outlines.half_widths(options, np.array([0.0, 1.0]))
    assert np.allclose([side[1] for side in found], [left, right])


def test_tip_radius_is_that_of_the_program():
    options = {"-indenter": "cone", "-indenter_half_angle": "70.3", "-indenter_tip_radius": "2"}
    heights = np.linspace(0, 3, 7)
    assert np.allclose(outlines.half_widths(options, heights)[0], tips.section_radius(heights, 70.3, 2))


@pytest.mark.parametrize("name, axes, boxes, labels", [
    ("tension", "xy", 1, ["bar: silicon", "tension, up to 8 GPa", "one level, cells of 2 µm", "side: symmetry", "side: free"]),
    ("wedge_3level", "xy", 3, ["workpiece: aluminium", "indenter: wedge", "boxes of levels 1 and 2", "cells of 0.5, 0.25, 0.125 µm",
                               "side: symmetry", "side: free"]),
    ("taylor_bar", "xy", 1, ["rod: copper, at 227 m/s", "one level, cells of 400 µm", "axis", "side: symmetry", "side: free"]),
    ("scratch", "xz", 1, ["block: metal", "indenter: sphere", "one level, cells of 0.125 µm", "side: symmetry", "side: fixed",
                          "side: free"]),
])
def test_picture_of_a_case(tmp_path, name, axes, boxes, labels):
    folder = harness.run({"max_steps": 1, "frames": 1}, file=f"{name}.opts").folder
    case = case_picture.read_case(folder)
    assert (case.axes, len(case.boxes)) == (axes, boxes)
    figure = case_picture.case(folder)
    legend = figure.axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == labels
    pictures.plt.close(figure)
    figures.main(["case", str(tmp_path / "case.png"), str(folder)])
    assert np.ptp(pictures.plt.imread(tmp_path / "case.png")) > 0.5


def test_a_folder_without_summary_has_no_case(tmp_path):
    folder = harness.run({"max_steps": 1, "frames": 1}, file="tension.opts").folder
    (folder / "summary.json").unlink()
    with pytest.raises(Error, match="no summary.json with the options"):
        case_picture.case(folder)


def test_boxes_that_move_later_are_those_of_their_points():
    levels = [{"position": np.array([[2.0, 2.0]]), "half_size": np.full((1, 2), 2.0)},
              {"position": np.array([[1.0, 1.0], [2.0, 1.0]]), "half_size": np.full((2, 2), 0.5)},
              {"position": np.zeros((0, 2)), "half_size": np.zeros((0, 2))}]
    summary = {"levels": [{"lower": [0, 0], "upper": [4, 4], "cell_size": 4}, {"lower": [2, 0], "upper": [4, 2], "cell_size": 2},
                          {"lower": [3, 0], "upper": [4, 1], "cell_size": 1}], "regrids": [{"level": 1}, {"level": 2}]}
    boxes, sizes = case_picture.first_boxes(summary, levels)
    assert boxes.tolist() == [[[0, 0], [4, 4]], [[0.5, 0.5], [2.5, 1.5]]] and sizes == [4, 2]


@pytest.mark.parametrize("span, side, axis, expected", [
    ("none,none", "x_upper", "y", None), ("1,5", "x_upper", "y", [1, 5]), ("1,5,2,4", "x_upper", "z", [2, 4]),
    ("1,5,2,4", "z_lower", "x", [1, 5])])
def test_span_of_a_load(span, side, axis, expected):
    case = case_picture.Case({"-press_span": span}, *[None] * 5)
    found = case_picture.span_along(case, "press", side, axis)
    assert found is None if expected is None else found.tolist() == expected
