"""Tips of laboratories in the analysis and in mlgimp.indent: files of profiles and maps, scripts/tip_map.py, Tip, and tests with durations."""
import math
import struct

import numpy as np
import pytest

import harness
import mlgimp
import tip_map
from mlgimp import height_maps, indentation, instrument, load_depth, tip_files, tips

pytestmark = pytest.mark.fast
FACE = math.tan(math.radians(65.27))


def berkovich(pixels, width, turn=0.0):
    """A HeightMap (um) of a Berkovich tip, down, whose apex is on a pixel; turn: of a face, degrees."""
    x = (np.arange(pixels) - pixels // 2) * width / pixels
    faces = np.radians(turn) + 2 * math.pi * np.arange(3) / 3
    heights = np.max([x[None, :] * math.cos(face) + x[::-1, None] * math.sin(face) for face in faces], axis=0) / FACE
    return height_maps.HeightMap(x, x[::-1], heights)


# ---- areas ----

def test_areas(tmp_path):
    """Of a profile, of a map and of a function against closed formulas (um, um2)."""
    r = np.linspace(0, 3e-6, 301)
    np.savetxt(tmp_path / "ball.txt", np.column_stack([r, 8e-6 - np.sqrt(64e-12 - r**2)]))
    ball = load_depth.tip_of_run({"-indenter": "profile", "-indenter_profile": str(tmp_path / "ball.txt")})
    assert float(ball.area(0.3)) == pytest.approx(math.pi * 0.3 * (16 - 0.3), rel=1e-5)
    height_maps.write_gsf(tmp_path / "tip.gsf", berkovich(201, 4.0), "tip")
    image = load_depth.tip_of_run({"-indenter": "height_map", "-indenter_map": str(tmp_path / "tip.gsf"), "-indenter_map_size": "none"})
    sharp = tips.make_tip("berkovich")
    for height in (0.2, 0.4):
        assert float(image.area(height)) == pytest.approx(float(sharp.area(height)), rel=5e-3)
    assert image.largest == pytest.approx(2 / FACE / 2, rel=0.02)  # where the rim is nearest, beside an edge
    area = load_depth.tip_of_run({"-indenter": "area_function", "-indenter_area_coefficients": "24.5,1e-6", "-indenter_area_depths": "none"})
    assert float(area.area(0.2)) == pytest.approx(24.5 * 0.04 + 1.0 * 0.2, rel=1e-12)
    assert load_depth.tip_of_run({"-indenter": "profile", "-indenter_profile": str(tmp_path / "gone.txt")}) is None


def test_other_tips():
    knoop = tips.make_tip("knoop")
    assert float(knoop.area(1.0)) == pytest.approx(2 * math.tan(math.radians(86.25)) * math.tan(math.radians(65)), rel=1e-4)  # 65.44 h2
    assert float(tips.make_tip("knoop", tip_radius=0.1).area(1.0)) > float(knoop.area(1.0))
    punch = tips.make_tip("flat_punch", radius=5, edge_radius=2)
    assert float(punch.area(1.0)) == pytest.approx(math.pi * (3 + math.sqrt(3)) ** 2)
    assert float(punch.area(3.0)) == pytest.approx(math.pi * 25)


AREA = {"-indenter": "area_function", "-indenter_area_depths": "none"}


def test_the_same_shape_has_the_same_beta(tmp_path):
    """A cone by name, by an area function and by a profile; a ball has 1; a pyramid by an area function that of its faces; those of
    calibrations stay at 1."""
    r = np.linspace(0, 3e-6, 301)
    np.savetxt(tmp_path / "cone.txt", np.column_stack([r, r / math.tan(math.radians(70.3))]))
    cone = tips.make_tip("cone", half_angle=70.3)
    exact = math.pi * math.tan(math.radians(70.3)) ** 2
    given = {"function": {**AREA, "-indenter_area_coefficients": repr(exact)},
             "profile": {"-indenter": "profile", "-indenter_profile": str(tmp_path / "cone.txt")}}
    for name, options in given.items():
        tip = load_depth.tip_of_run(options)
        assert np.allclose(tip.beta(0.3, np.array([0.05, 0.2])), cone.beta(0.3, 0.2), rtol=1e-6), name
    ball = load_depth.tip_of_run({**AREA, "-indenter_area_coefficients": f"{-math.pi!r},{2 * math.pi * 5e-6!r}"})
    assert 1 < ball.beta(0.3, 0.01) < 1.02 and math.isnan(ball.beta(0.3, -0.01))
    worn = load_depth.tip_of_run({**AREA, "-indenter_area_coefficients": "24.5,1200e-9"})
    slope = (2 * 24.5 * 0.2 + 1.2) / 2 / math.sqrt(math.pi * (24.5 * 0.04 + 1.2 * 0.2))  # da/dh
    assert worn.beta(0.17, 0.2) == pytest.approx(tips.hay(slope, 0.17), rel=1e-4)
    faces = load_depth.tip_of_run({**AREA, "-indenter_area_coefficients": "24.5", "-indenter_faces": "3"})
    assert faces.beta(0.3, 0.2) == tips.make_tip("berkovich").beta(0.3, 0.2) == 1.034
    assert tips.tip_of_function([24.5]).beta(0.3, 0.2) == 1


# ---- maps ----

def test_a_map_is_read_as_it_was_written(tmp_path):
    image = berkovich(41, 4.1, turn=17)
    height_maps.write_gsf(tmp_path / "tip.gsf", image, "tip")
    np.savetxt(tmp_path / "tip.csv", 1e-6 * image.height, delimiter=",")
    for read in (height_maps.read_map(tmp_path / "tip.gsf"), height_maps.read_map(tmp_path / "tip.csv", (4.1, 4.1))):
        np.testing.assert_allclose(read.height, image.height, atol=1e-6)
        assert np.ptp(read.x) == pytest.approx(np.ptp(image.x)) and read.y[0] > read.y[-1]
    for content, words in ((b"Gwyddion Simple Field 1.0\nXRes = 2\n\0\0", "in 'None'"), (b"1 2\nx y", "no map of heights")):
        (tmp_path / "bad").write_bytes(content)
        with pytest.raises(mlgimp.ResultError, match=words):
            height_maps.read_map(tmp_path / "bad", (1, 1))
    with pytest.raises(mlgimp.ResultError, match="extents"):
        height_maps.read_map(tmp_path / "tip.csv")


def binary_stl(triangles):
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(struct.pack("<12f2x", 0, 0, 0, *np.ravel(each)) for each in triangles)


def text_stl(triangles):
    facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in each) + "endloop\nendfacet\n" for each in triangles)
    return ("solid tip\n" + facets + "endsolid tip\n").encode()


def test_map_of_an_image_and_of_a_surface(tmp_path, capsys):
    """An image of a tip that points up is turned over about x; the same tip as a surface of triangles has the same map."""
    tip = berkovich(61, 6.1, turn=17)
    up = height_maps.HeightMap(tip.x, -tip.y[::-1], 2.0 - tip.height[::-1])  # as it stands upside down under a microscope
    height_maps.write_gsf(tmp_path / "image.gsf", up, "image")
    tip_map.main([str(tmp_path / "image.gsf"), str(tmp_path / "tip.gsf")])
    np.testing.assert_allclose(height_maps.read_map(tmp_path / "tip.gsf").height, tip.height, atol=1e-6)
    assert "61 x 61 pixels of 100 nm" in capsys.readouterr().out
    with pytest.raises(SystemExit, match="on its rim: leave --down out"):
        tip_map.main([str(tmp_path / "image.gsf"), str(tmp_path / "tip.gsf"), "--down"])
    corners = [[FACE / math.cos(math.pi / 3) * math.cos(angle), FACE / math.cos(math.pi / 3) * math.sin(angle), 1.0]
               for angle in math.radians(17 + 60) + 2 * math.pi * np.arange(3) / 3]
    faces = np.array([[[0, 0, 0], corners[k], corners[(k + 1) % 3]] for k in range(3)])
    for name, content in (("binary.stl", binary_stl(faces)), ("text.stl", text_stl(faces))):
        (tmp_path / name).write_bytes(content)
        tip_map.main([str(tmp_path / name), str(tmp_path / "surface.gsf"), "--down", "--pixel", "50"])
        read = height_maps.read_map(tmp_path / "surface.gsf")
        row, column = np.unravel_index(np.argmin(read.height), read.height.shape)
        assert read.height[row, column + 20] == pytest.approx(math.cos(math.radians(17)) / FACE, abs=0.03)  # a face beside it, 1 um along x
    (tmp_path / "bad.stl").write_bytes(b"solid\nvertex 1 2 3\n")
    with pytest.raises(SystemExit, match="is no STL"):
        tip_map.main([str(tmp_path / "bad.stl"), str(tmp_path / "x.gsf")])


# ---- indent ----

VENDOR = (32.9049, -6418.303798, 288484.8518, -989287.0625, 103588.5588, 675977.3345)


def test_units_of_area_functions():
    """C of nm and of m make the same area, each by itself: factors 10^(9 (2 - 2^(1 - k)))."""
    for k, factor in enumerate((1, 1e9, 10**13.5, 10**15.75, 10**16.875, 10**17.4375)):
        assert instrument.area_factor(k) == pytest.approx(1 / factor, rel=1e-12)
    options = mlgimp.Tip(area_nm=VENDOR, frame=5e6, depths_nm=(20, 5000)).options()
    tip = load_depth.tip_of_run({f"-{name}": indentation.as_text(value) for name, value in options.items()})
    for depth, area in ((0.1, 529306.4254), (0.15, 967026.1576), (1.0, 31332720.86)):  # nm2, by hand
        assert float(tip.area(depth)) == pytest.approx(1e-6 * area, rel=1e-8)
    assert options["indenter_stiffness"] == 5e6 and options["indenter_area_depths"] == (20e-9, 5000e-9)


METAL = dict(youngs_modulus=70e9, yield_stress=400e6)


def option_of(groups, name):
    return next(group[name] for group in groups if name in group)


def test_a_test_with_durations():
    groups = indentation.indentation_options("j2", tip=mlgimp.Tip(area_nm=VENDOR), test=[(10, "10mN"), (30, "hold"), (10, 0)], **METAL)
    assert option_of(groups, "test_times") == [0, 10, 40, 50] and option_of(groups, "indenter_loads") == [0, 0.01, 0.01, 0]
    quarter = indentation.indentation_options("j2", tip="vickers", geometry="3d", test=[(1, "4 mN")], **METAL)
    assert option_of(quarter, "indenter_loads") == [0, pytest.approx(1e-3)]
    depths = indentation.indentation_options("j2", tip="vickers", test=[(1, "200nm"), (5, "hold"), (1, "50 nm")], **METAL)
    assert option_of(depths, "indenter_depths") == [0, pytest.approx(200e-9), pytest.approx(200e-9), pytest.approx(50e-9)]


def test_models_of_space():
    """A tip that may be cut by a side of symmetry makes a part of a model, a tilted one the whole."""
    for tip, sides in ((mlgimp.Tip("berkovich"), [False, True]), (mlgimp.Tip("knoop"), [True, True]), (mlgimp.Tip("berkovich", tilt=(3, 0)), [False, False]),
                       (mlgimp.Tip(area_nm=[24.5], faces=4), [True, True]), (mlgimp.Tip(area_nm=[24.5], faces=3), [False, True]),
                       (mlgimp.Tip("sphere", radius=1e-6), [True, True])):
        assert tip.mirrors() == sides, tip


@pytest.mark.parametrize("make, words", [
    (lambda: mlgimp.Tip(), "one of kind, area_nm"), (lambda: mlgimp.Tip("cone", area_nm=[1]), "one of kind"),
    (lambda: mlgimp.Tip("cone", poissons_ratio=0.1), "beside youngs_modulus"),
    (lambda: instrument.turns_of([(10, "10GPa")]), "10GPa"), (lambda: instrument.turns_of([(10, "10mN"), (1, "5nm")]), "loads, or depths"),
    (lambda: instrument.turns_of([(-1, "10mN")]), "test=-1"), (lambda: instrument.turns_of("10mN"), "list of"),
    (lambda: instrument.turns_of([(1, "hold")]), "at least one above 0"), (lambda: instrument.turns_of([(1, 10)]), "with its unit")])
def test_refusals(make, words):
    with pytest.raises(mlgimp.Error, match=words):
        make()


def test_indent_with_an_instruments_tip(tmp_path, monkeypatch):
    """A run by a calibrated tip with a frame: its curve has the tip, and depths without the frame."""
    monkeypatch.chdir(tmp_path)
    frame = 1e6
    test = mlgimp.indent("neo_hookean", youngs_modulus=72e9, poissons_ratio=0.17, tip=mlgimp.Tip(area_nm=VENDOR, frame=frame), depth=300e-9, cells=4, block=8,
                         tolerance=0.1, frames=0, file="silica.opts")
    history, curve = test.history, test.curve()
    assert curve.tip.name == "area function"
    row = int(np.argmax(history["measured_depth"]))
    assert history["measured_depth"][row] == pytest.approx(300e-9, rel=1e-6)
    assert 1e6 * (history["measured_depth"] - history["depth"])[row] == pytest.approx(1e6 * history["load"][row] / frame, rel=2e-3)
    assert curve.depth.max() == pytest.approx(1e6 * history["depth"].max(), rel=5e-3)
