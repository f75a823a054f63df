"""Checks maps of imprints: places, handedness and completed sides on made surfaces, files by a reader of their own, profiles, refusals."""
import json
import re
import struct

import h5py
import numpy as np
import pytest

import mlgimp
from made_curves import CONE_OPTIONS, HALF, QUARTER
from mlgimp import imprint
from mlgimp.errors import Error
from test_scripts import HISTORY

import imprint as command  # scripts/imprint.py

pytestmark = pytest.mark.fast

TOP = 8e-6  # of the undeformed surface, where the tip of OPTIONS is
WHOLE = {**HALF, "-domain_lower": "-1e-5,-1e-5,0"}  # the tip is on no side


def write_run(folder, options, corners, heights, area=0.0):
    """A result folder with a flat surface in frame 0 and another in frame 1: patches with corners [n][corners][dim - 1] (m), heights [n][corners]."""
    folder.mkdir()
    columns = dict.fromkeys(HISTORY, np.zeros(3)) | {"time": np.arange(3.0), "depth": np.arange(3) * 1e-7, "load": np.arange(3.0)}
    np.savetxt(folder / "history.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    dim = corners.shape[2] + 1
    level = {"lower": [0] * dim, "upper": [1] * dim, "cell_size": 1e-7}
    (folder / "summary.json").write_text(json.dumps({"case": "made", "levels": [level], "options": options}))
    for number, above in enumerate((np.zeros_like(heights), heights)):
        with h5py.File(folder / f"points_{number:06d}.h5", "w") as file:
            file.attrs.update({"time": float(number), "step": number, "contact_area": area * number})
            file.create_group("surface")["position"] = np.concatenate([corners, TOP + above[..., None]], axis=2).reshape(-1, dim)
    return folder


def quads(lower, upper, count):
    """Corners [n][4][2] of count x count patches of a rectangle, around each patch."""
    x, y = (np.linspace(lower[axis], upper[axis], count + 1) for axis in (0, 1))
    return np.array([[(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])] for i in range(count) for j in range(count)])


def read_gsf(path):
    """An independent reader, by the format's description: header and heights [rows][columns]."""
    content = path.read_bytes()
    lines, place = [], 0
    while content[place] != 0:
        end = content.index(b"\n", place)
        lines.append(content[place:end].decode())
        place = end + 1
    padding = 4 - place % 4
    assert lines[0] == "Gwyddion Simple Field 1.0" and content[place:place + padding] == b"\0" * padding
    header = dict(re.fullmatch(r"(\w+) = (.*)", line).groups() for line in lines[1:])
    shape = int(header["YRes"]), int(header["XRes"])
    assert len(content) == place + padding + 4 * shape[0] * shape[1]
    return header, np.array(struct.unpack(f"<{shape[0] * shape[1]}f", content[place + padding:])).reshape(shape)


def test_right_is_right_and_up_is_up(tmp_path, expect):
    """A hill to the right of the axis and a hollow above it, none symmetric; x grows along the columns, y falls along the rows."""
    corners = quads((-4e-6, -4e-6), (4e-6, 4e-6), 64)
    x, y = np.moveaxis(corners, 2, 0)
    folder = write_run(tmp_path / "run", WHOLE, corners, 1e-7 * np.exp(-((x - 1e-6) ** 2 + y**2) / 0.5e-12) - 3e-7 * np.exp(-(x**2 + (y - 2e-6) ** 2) / 0.5e-12))
    image = mlgimp.read(folder).imprint(out=tmp_path)
    top, low = (np.unravel_index(pick(image.height), image.height.shape) for pick in (np.nanargmax, np.nanargmin))
    assert abs(image.x[top[1]] - 1) < 0.11 and abs(image.y[top[0]]) < 0.11 and abs(image.x[low[1]]) < 0.11 and abs(image.y[low[0]] - 2) < 0.11
    header, heights = read_gsf(tmp_path / "surface.gsf")
    rows, columns = heights.shape
    assert low[0] < rows / 2 and top[1] > columns / 2  # above, right
    expect("heights in m", float(np.max(np.abs(heights - 1e-6 * image.height)) / 3e-7), at_most=1e-6)
    expect("width", float(header["XReal"]) / (columns * 1e-6 * (image.x[1] - image.x[0])), near=1, tolerance=1e-8)
    expect("left edge", float(header["XOffset"]) / float(header["XReal"]), near=-0.5, tolerance=1e-8)
    table = np.loadtxt(tmp_path / "surface.csv", delimiter=",")
    expect("the matrix", float(np.max(np.abs(table - 1e-6 * image.height)) / 3e-7), at_most=1e-8)


@pytest.mark.parametrize("title", ["a", "ab", "abc", "abcd"])
def test_headers_of_all_lengths(tmp_path, title):
    """One to four zeros lie between the header and the numbers, which begin at a multiple of four bytes."""
    image = imprint.HeightMap(np.arange(3.0), np.arange(2.0)[::-1], np.arange(6.0).reshape(2, 3))
    imprint.write_gsf(tmp_path / "s.gsf", image, title)
    assert np.allclose(read_gsf(tmp_path / "s.gsf")[1], 1e-6 * image.height)


def test_planes_are_exact(tmp_path, expect):
    """Between the corners heights are linear: those of a plane are exact at each pixel, whatever the patches."""
    corners = quads((-3e-6, -2e-6), (5e-6, 4e-6), 7)
    plane = 0.1 * corners[..., 0] - 0.2 * corners[..., 1] - 2e-6
    image = imprint.height_map(write_run(tmp_path / "run", WHOLE, corners, plane))
    x, y = np.meshgrid(image.x, image.y)
    inside = (x >= -3) & (x <= 5) & (y >= -2) & (y <= 4)
    expect("heights", float(np.max(np.abs(image.height - (0.1 * x - 0.2 * y - 2))[inside])), at_most=1e-9)
    assert np.isnan(image.height[~inside]).all() and (~inside).any()


@pytest.mark.parametrize("options, lower", [(QUARTER, (0, 0)), (HALF, (-4e-6, 0))], ids=["quarter", "half"])
def test_sides_of_symmetry_are_completed(tmp_path, options, lower):
    """The imprint of a quarter is the same on four sides, that of a half on two; what is unsymmetric in a half stays so."""
    corners = quads(lower, (4e-6, 4e-6), 32)
    x, y = np.moveaxis(corners, 2, 0)
    folder = write_run(tmp_path / "run", options, corners, -3e-7 * np.exp(-((x - 0.5e-6) ** 2 + y**2) / 1e-12))
    image = imprint.height_map(folder)
    assert np.allclose(image.height, image.height[::-1]) and np.allclose(image.height, image.height[:, ::-1]) == (options is QUARTER)
    assert image.height.shape[0] == len(image.y) and abs(image.x[0] + image.x[-1]) < 1e-12 and np.nanmin(image.height) == pytest.approx(-0.3, rel=0.02)


@pytest.fixture
def cone(tmp_path):
    """An axisymmetric imprint with a pile-up, of segments from outside to the axis."""
    radius = np.linspace(4e-6, 0, 81)
    corners = np.stack([radius[:-1], radius[1:]], axis=1)[..., None]
    return write_run(tmp_path / "run", CONE_OPTIONS, corners, height_at(corners[..., 0]))


def height_at(radius):
    return -2e-7 * np.maximum(1 - radius / 6e-7, 0) + 3e-8 * np.exp(-((radius - 8e-7) / 2e-7) ** 2)


def test_revolution(cone, expect):
    """Pile-up and all: the heights are those of the profile at each pixel's distance from the axis."""
    image = imprint.height_map(cone)
    radius = np.hypot(*np.meshgrid(image.x, image.y))
    expect("heights", float(np.max(np.abs(image.height - 1e6 * height_at(1e-6 * radius)))), at_most=1e-3)
    assert image.height.max() > 0.029 and image.x[1] - image.x[0] == pytest.approx(0.05) and image.x[-1] > 1.0
    finer = imprint.height_map(cone, pixel=0.02)
    assert finer.x[1] - finer.x[0] == pytest.approx(0.02) and len(finer.x) > 2 * len(image.x)
    flat = imprint.height_map(cone, 0)
    assert np.nanmax(np.abs(flat.height)) < 1e-9


def test_profiles(cone, tmp_path):
    """That of a run, and one in a text with columns, in whatever order."""
    own = imprint.profile_of(cone)
    assert np.all(np.diff(own.radius) > 0) and np.allclose(own.height, 1e6 * height_at(1e-6 * own.radius))
    np.savetxt(tmp_path / "p.csv", np.column_stack([1e3 * own.radius, 1e3 * own.height])[::-1], delimiter=";", header="r (nm);z (nm)", comments="")
    read = imprint.read_profile(tmp_path / "p.csv", "r:nm", "z:nm")
    assert np.allclose(read.radius, own.radius) and np.allclose(read.height, own.height)
    np.savetxt(tmp_path / "n.csv", np.column_stack([own.radius - 1, own.height]), delimiter=";", header="radius;height", comments="")
    with pytest.raises(Error, match="radii below zero"):
        imprint.read_profile(tmp_path / "n.csv")


def test_command(cone, tmp_path, capsys):
    command.main([str(cone), "--out", str(tmp_path / "there"), "--pixel", "25"])
    printed = capsys.readouterr().out
    assert "pixels of 25 nm" in printed and "still touches" not in printed and read_gsf(tmp_path / "there" / "surface.gsf")[0]["Title"] == "imprint of made"
    with h5py.File(cone / "points_000001.h5", "r+") as file:
        file.attrs["contact_area"] = 1e-12
    command.main([str(cone)])
    assert "the tip still touches" in capsys.readouterr().out and (cone / "surface.csv").exists()


@pytest.mark.parametrize("words, line", [
    (["none"], "history.csv"), (["run", "--frame", "7"], "no frame 7; there are 0 to 1"), (["run", "--pixel", "0"], "--pixel 0: must be a number > 0"),
    (["run", "--pixel", "0.001"], "must be at least"), (["run", "--out", "/dev/null/none"], "cannot be written to"), (["run", "--pixel", "nan"], "--pixel nan")])
def test_refusals(cone, monkeypatch, words, line):
    monkeypatch.chdir(cone.parent)
    with pytest.raises(SystemExit) as caught:
        command.main(words)
    assert re.fullmatch(rf"error: [^\n]*{re.escape(line)}[^\n]*", str(caught.value.code)), caught.value.code


def test_runs_without_an_imprint(cone):
    """In plane strain, and without a surface, as with -contact other than pressure."""
    summary = json.loads((cone / "summary.json").read_text())
    (cone / "summary.json").write_text(json.dumps(summary | {"options": CONE_OPTIONS | {"-geometry": "plane_strain"}}))
    with pytest.raises(Error, match="plane strain"):
        imprint.height_map(cone)
    (cone / "summary.json").write_text(json.dumps(summary))
    with h5py.File(cone / "points_000001.h5", "r+") as file:
        del file["surface"]
    with pytest.raises(Error, match="has no surface: it needs a run with -contact pressure"):
        imprint.height_map(cone)
