"""Pictures for a paper, and by logarithms: width, text, endings of files, and which fields span decades."""
import re

import numpy as np
import pytest
from matplotlib.colors import LogNorm, Normalize, SymLogNorm
from matplotlib.text import Text

import mlgimp
from mlgimp import fields, gallery, pictures, surface
from mlgimp.fields import Scale
from test_package import pressed  # noqa: F401, a fixture

pytestmark = pytest.mark.fast


@pytest.mark.parametrize("name", ["load_depth", "contact_pressure", "von_mises_stress", "stress_xy", "energy"])
def test_for_a_paper(pressed, tmp_path, name):  # noqa: F811
    """85 mm wide, all text 8 points, no title, and nothing outside of the picture."""
    figure = pressed[0].plot(name, style="paper")[name]
    figure.draw_without_rendering()
    assert figure.get_figwidth() == pytest.approx(85 / 25.4)
    texts = [text for text in figure.findobj(Text) if text.get_text().strip() and text.get_visible()]
    assert texts and {text.get_fontsize() for text in texts} == {8} and not any(axes.get_title() for axes in figure.axes)
    whole, inside = figure.bbox, figure.get_tightbbox(figure.canvas.get_renderer())
    assert inside.x0 >= -0.02 and inside.y0 >= -0.02 and inside.x1 * figure.dpi <= whole.width + 4 and inside.y1 * figure.dpi <= whole.height + 4
    pictures.plt.close(figure)
    on_screen = pressed[0].plot(name)[name]
    assert on_screen.get_figwidth() > 6 and any(axes.get_title() for axes in on_screen.axes)
    pictures.plt.close(on_screen)


def test_fields_for_a_paper_fill_their_width(pressed):  # noqa: F811
    figure = pressed[0].plot("von_mises_stress", style="paper")["von_mises_stress"]
    inside = figure.get_tightbbox(figure.canvas.get_renderer())
    assert inside.x1 > figure.get_figwidth() - 0.1
    pictures.plt.close(figure)


def test_energies_that_no_line_shows_are_told():
    history = dict.fromkeys(pictures.ENERGIES, np.array([0, 1e-9])) | {"kinetic_energy": np.array([0, 2e-12]), "external_work": np.zeros(2)}
    assert pictures.size_if_hidden(history, "kinetic_energy") == ",\nat most 2 pJ"
    assert pictures.size_if_hidden(history, "strain_energy") == pictures.size_if_hidden(history, "external_work") == ""


def test_files(pressed, tmp_path):  # noqa: F811
    """By the ending of a file, or as .pdf in a folder; the width of the page is that of a column in points."""
    run = pressed[0]
    run.plot("load_depth", out=tmp_path / "one.svg", style="paper")
    assert float(re.search(r'<svg [^>]*width="([0-9.]+)pt"', (tmp_path / "one.svg").read_text())[1]) == pytest.approx(85 / 25.4 * 72, rel=1e-3)
    run.plot("load_depth", "energy", out=tmp_path / "all", style="paper")
    assert sorted(path.name for path in (tmp_path / "all").iterdir()) == ["energy.pdf", "load_depth.pdf"]
    assert float(re.search(rb"/MediaBox \[ 0 0 ([0-9.]+)", (tmp_path / "all" / "energy.pdf").read_bytes())[1]) == pytest.approx(85 / 25.4 * 72, rel=1e-3)
    with pytest.raises(mlgimp.Error, match="must be a folder for 2 pictures"):
        run.plot("load_depth", "energy", out=tmp_path / "two.pdf")
    with pytest.raises(mlgimp.Error, match="style=poster: must be one of screen, paper"):
        run.plot("energy", style="poster")


def test_the_command(pressed, tmp_path, capsys):  # noqa: F811
    import plot
    plot.main([str(pressed[0].folder), "--picture", "stress_yy", "--style", "paper", "--log", "--out", str(tmp_path / "yy.pdf")])
    assert (tmp_path / "yy.pdf").read_bytes().startswith(b"%PDF") and capsys.readouterr().out == f"{tmp_path / 'yy.pdf'}\n"
    with pytest.raises(SystemExit, match="error: --picture yy: must be one of load_depth"):
        plot.main([str(pressed[0].folder), "--picture", "yy"])


@pytest.mark.parametrize("scale, kind, ends", [
    (Scale(0, 2e9, ""), LogNorm, (2e6, 2e9)), (Scale(-2e9, 0, ""), SymLogNorm, (-2e9, 2e6)), (Scale(-1e9, 1e9, ""), SymLogNorm, (-1e9, 1e9))])
def test_norms(scale, kind, ends):
    norm = fields.norm_of(scale, 1, is_log=True)
    assert type(norm) is kind and (norm.vmin, norm.vmax) == pytest.approx(ends)
    assert type(fields.norm_of(scale)) is Normalize and np.all(np.diff(norm(np.linspace(*ends, 50))) > 0)


def test_fields_that_span_decades():
    steep, flat = np.geomspace(1, 1e6, 1000), np.linspace(1, 2, 1000)
    assert fields.spans_decades(steep) and fields.spans_decades(-steep) and not fields.spans_decades(flat) and not fields.spans_decades(np.zeros(5))


def test_one_scale_of_several_frames():
    """A frame in which nothing has happened yet leaves it as it is, and of both signs it is symmetric."""
    assert fields.common_scale([(0, 0), (0, 2)], "equivalent_plastic_strain") == Scale(0, 2, "magma_r")
    assert fields.common_scale([(-1, 0), (0, 2)], "xx") == Scale(-2, 2, "RdBu_r")


def test_a_small_contact_is_shown_near(pressed):  # noqa: F811
    """By default of the command, where the contact is a dot in all that there is; the title says so."""
    run = pressed[0]
    panel = fields.read_panel(run.folder)
    left, right, *_ = fields.extent(panel)
    for half, small in ((0.04, True), (0.2, False)):
        history = {"contact_half_width": np.array([0, half * (right - left)])}
        assert gallery.is_small(history, panel._replace(boxes=np.zeros((2, 2, 2)))) == small
        assert not gallery.is_small(history, panel._replace(boxes=panel.boxes[:1]))
    assert not gallery.is_small({}, panel)


def test_windows_and_frames_of_the_command(pressed, tmp_path, monkeypatch):  # noqa: F811
    """--window all is everything, nothing is auto, and a frame is a number or that of the largest load."""
    import plot
    asked = []
    monkeypatch.setattr(plot, "gallery", lambda *arguments: asked.append(arguments[1:3]) or {})
    for words in ([], ["--window", "all"], ["--window", "near", "--frame", "largest_load"], ["--frame", "1"]):
        plot.main([str(pressed[0].folder), *words])
    assert asked == [(None, "auto"), (None, None), ("largest_load", "near"), (1, "auto")]
    frame = surface.frame_of_largest_load(pressed[0].folder)
    one, other = (gallery.gallery(pressed[0].folder, number)["stress_yy"]() for number in ("largest_load", frame))
    assert one.axes[0].get_title() == other.axes[0].get_title()


def test_long_titles_have_lines():
    assert pictures.in_lines("a case, t = 22.5 ns, depth 450 nm, load 4.325 mN", 2.5) == "a case, t = 22.5 ns\ndepth 450 nm\nload 4.325 mN"
    assert pictures.in_lines("a case, t = 22.5 ns", 6) == "a case, t = 22.5 ns" and pictures.in_lines("x" * 100, 1) == "x" * 100
