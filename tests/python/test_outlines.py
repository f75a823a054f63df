"""The indenter in pictures of fields: at its place of that frame, touching the body, whole or half as the body is."""
import numpy as np
import pytest

import mlgimp
from mlgimp import fields, outlines, pictures
from test_package import PRESS, pressed  # noqa: F401, a fixture

pytestmark = pytest.mark.fast


def test_place_of_the_indenter(pressed):  # noqa: F811
    """Its lowest corner is the tip of the history at the time of the frame; of a half model only the right half is there."""
    run = pressed[0]
    for number, time in run.frames.items():
        panel = fields.read_panel(run.folder, number)
        lowest = panel.indenter[np.argmin(panel.indenter[:, 1])]
        assert lowest == pytest.approx([0, np.interp(time, run.history["time"], run.history["tip_y"])], abs=1e-12)
        assert panel.indenter[:, 0].min() == 0 and panel.indenter[:, 1].max() > panel.points["position"][:, 1].max()
    assert lowest[1] == pytest.approx(PRESS["indenter_tip"][1] - PRESS["indenter_max_depth"], abs=0.01)


def test_nothing_is_inside_the_indenter(pressed):  # noqa: F811
    """No point's centre is deeper inside the cylinder than a hundredth of its radius."""
    panel = fields.read_panel(pressed[0].folder)
    tip = panel.indenter[np.argmin(panel.indenter[:, 1])]
    radius = PRESS["indenter_radius"]
    away = np.linalg.norm(panel.points["position"] - tip - [0, radius], axis=1)
    assert away.min() > 0.99 * radius


def test_pictures_have_it(pressed):  # noqa: F811
    """As a shape over the field, and the title has time, depth and load."""
    figure = pressed[0].plot("von_mises_stress")["von_mises_stress"]
    shapes = [patch for patch in figure.axes[0].patches if len(patch.get_xy()) > 100]
    assert len(shapes) == 1 and all(word in figure.axes[0].get_title() for word in ("t = 250 ms", "depth 500 mm", "load "))
    pictures.plt.close(figure)


def test_indenter_of_a_file_that_is_gone():
    options = {"-indenter": "profile", "-indenter_profile": "absent.csv", "-geometry": "axisymmetric"}
    assert outlines.outline(options, 1e-6).shape == (0, 2)


def test_polygon():
    options = {"-indenter": "polygon", "-indenter_vertices": "1,2,3,5,-1,5"}
    assert outlines.outline(options, 1.0).tolist() == [[0, 0], [2, 3], [-2, 3]]


def test_state_in_words():
    history = mlgimp.results.History(time=np.array([0, 1e-9, 2e-9]), depth=np.array([0, 1e-7, 2e-7]), load=np.array([0, 1e-3, 3e-3]))
    assert fields.state_at(history, 1e-9) == "t = 1 ns, depth 100 nm, load 2 mN"  # the mean over an interval belongs to its middle
    away = mlgimp.results.History(time=np.array([0, 1e-9, 2e-9, 3e-9]), depth=np.full(4, 1e-7), load=np.array([0, 1e-3, 1e-13, 1e-13]))
    assert fields.state_at(away, 3e-9) == "t = 3 ns, depth 100 nm, load 0 N"
    still = mlgimp.results.History(time=np.array([0, 1e-9]), depth=np.zeros(2), load=np.zeros(2))
    assert fields.state_at(still, 0.5e-9) == "t = 500 ps"
