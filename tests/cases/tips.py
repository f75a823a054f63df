"""Indenters of laboratories: area functions, profiles, maps of heights, rounded punches and tilted tips, against exact ones."""
import math

import numpy
import pytest

import harness
import studies_page as page
from refusals import Table, expect_refused

# An elastic body of small strain under a tip of revolution whose contact is eight cells wide in the end; cells are 1.
CELLS = 8
MODULUS = 1 / (1 - 0.3**2)  # E*
BODY = {"materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "b", "boundary_y_lower": "symmetry",
        "boundary_x_upper": "symmetry", "geometry": "axisymmetric", "quasi_static": "true", "quasi_static_tolerance": 0.05, "frames": 0}


def block(radii, cell=1.0):
    """A block of so many radii of the contact, a power of two, on levels that grow with the distance from the tip; cell: finest, m."""
    half, levels = CELLS * radii * cell, int(math.log2(radii)) - 1
    top = half + 2**levels * cell
    case = {**BODY, "domain_lower": "0,0", "domain_upper": (half, top), "cell_size": 2**(levels - 1) * cell, "levels": levels,
            "b_lower": "0,0", "b_upper": (half, half), "indenter_tip": (0.0, half)}
    for k in range(1, levels):
        case[f"level_{k}_lower"], case[f"level_{k}_upper"] = (0.0, half - half / 2**k), (half / 2**k, top)
    return case


def sneddon(slope, radius):
    """h and P/E* of a frictionless tip whose profile has slope(r), where the contact has a radius: Sneddon, Int. J. Eng. Sci. 3 (1965) 47.

    With r = a sin(t): h = int a f' dt, P = 2 E* int a^2 sin^2(t) f' dt, t from 0 to pi/2, by the midpoint rule.
    """
    t = (numpy.arange(20000) + 0.5) * math.pi / 2 / 20000
    f = slope(radius * numpy.sin(t))
    return numpy.mean(radius * f) * math.pi / 2, 2 * numpy.mean((radius * numpy.sin(t))**2 * f) * math.pi / 2


def deepest(result, depth):
    """Load and radius of the contact at rest at the largest depth."""
    history = result.history
    rest = history["depth"] > depth * (1 - 1e-6)
    return [float(numpy.mean(history[name][rest])) for name in ("load_quasi_static", "contact_half_width")]


# ---- tips of revolution ----

R, FLAT, EDGE, ANGLE = 320.0, 7.0, 32.0, 88.5  # slopes of 1/40: at 1/10 strains of finite size add .6 % to the load
CONE = math.tan(math.radians(ANGLE))


def of_area(r):
    """Slope of the tip with A = pi tan^2 h^2 + 2 pi R h: z with tan^2 z^2 + 2 R z = r^2."""
    return r / numpy.sqrt(R**2 + (CONE * r)**2)


def of_edge(r):
    """Of a level disk of the radius FLAT with a round edge around it."""
    across = numpy.clip(r - FLAT, 0, EDGE)
    return across / numpy.sqrt(numpy.maximum(EDGE**2 - across**2, 1e-12))


def of_fourth_power(r):
    return 0.025 * (r / CELLS)**3


def profile_file(folder, height, reach, name="profile.txt"):
    """A file with a profile from its heights."""
    r = numpy.linspace(0, reach, 400)
    path = folder / name
    numpy.savetxt(path, numpy.column_stack([r, height(r)]), header="r z")
    return path


def tip_cases(folder):
    power = profile_file(folder, lambda r: 0.00625 * CELLS * (r / CELLS)**4, 3 * CELLS)
    return {
        "area function": ({"indenter": "area_function", "indenter_area_coefficients": (math.pi * CONE**2, 2 * math.pi * R)}, of_area, CELLS),
        "rounded punch": ({"indenter": "flat_punch", "indenter_radius": FLAT + EDGE, "indenter_edge_radius": EDGE}, of_edge, CELLS),
        "fourth power": ({"indenter": "profile", "indenter_profile": power}, of_fourth_power, CELLS),
    }


def pressed(tip, slope, radius, radii):
    """Ratios of load and radius to Sneddon's at his depth."""
    return ratios_of(press(tip, slope, radius, radii), slope, radius)


def press(tip, slope, radius, radii):
    """Result of a tip that is pressed to Sneddon's depth of a contact radius, on a block of so many of them."""
    return harness.run({**block(radii), **tip, "indenter_depths": sneddon(slope, radius)[0]})


def ratios_of(result, slope, radius):
    depth, load = sneddon(slope, radius)
    found, width = deepest(result, depth)
    return found / (MODULUS * load), width / radius


@pytest.mark.parametrize("name", ["area function", "rounded punch", "fourth power"])
def test_sneddon(expect, name, tmp_path):
    """Blocks of 8 and 16 radii, whose sides take as much from the depth as they are near, say what a half space has. Seen: load .1 to .3 %, radius
    .4 to .6 %."""
    tip, slope, radius = tip_cases(tmp_path)[name]
    ratios = [pressed(tip, slope, radius, radii) for radii in (8, 16)]
    for k, (what, limit) in enumerate((("load", 0.01), ("radius", 0.015))):
        expect(f"{name}: {what} over Sneddon's in a half space", 2 * ratios[1][k] - ratios[0][k], near=1, tolerance=limit)


def test_area_function_of_a_cone(expect):
    """C0 alone is a cone, step by step. Seen: 5e-12."""
    case = {**block(8), "max_steps": 300, "indenter_depths": 0.5}
    loads = [harness.run({**case, **tip}).history["load"] for tip in (
        {"indenter": "cone", "indenter_half_angle": 70.3},
        {"indenter": "area_function", "indenter_area_coefficients": math.pi * math.tan(math.radians(70.3))**2})]
    expect("load of an area function with C0 alone, less a cone's, of its largest", numpy.max(numpy.abs(loads[1] - loads[0])) / loads[0].max(), at_most=1e-9)


# ---- tips of space ----

SPACE = {"geometry": "3d", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "b", "domain_lower": "-8,-8,0",
         "domain_upper": "8,8,10", "cell_size": 1, "b_lower": "-8,-8,0", "b_upper": "8,8,8", "b_points_per_cell": 1, "boundary_z_lower": "symmetry",
         "indenter_tip": "0,0,8", "quasi_static": "true", "quasi_static_tolerance": 0.1, "indenter_depths": 0.8, "frames": 0}


def berkovich_heights(pixels, width, turn=0.0):
    """Heights [rows][columns] of a Berkovich tip over a square, rows along x and the first at the smallest y; the apex is on a pixel."""
    x = (numpy.arange(pixels) - pixels // 2) * width / pixels
    faces = numpy.radians(turn) + 2 * math.pi * numpy.arange(3) / 3
    across = [x[None, :] * math.cos(face) + x[:, None] * math.sin(face) for face in faces]
    return numpy.max(across, axis=0) / math.tan(math.radians(65.27))


def write_field(path, heights, width):
    """A Gwyddion Simple Field, as its manual has it: a head, zero bytes up to a multiple of four, rows from the top in single precision."""
    rows, columns = heights.shape
    head = f"Gwyddion Simple Field 1.0\nXRes = {columns}\nYRes = {rows}\nXReal = {width}\nYReal = {width}\nXYUnits = m\nZUnits = m\n".encode()
    path.write_bytes(head + bytes(4 - len(head) % 4) + heights[::-1].astype("<f4").tobytes())


def test_map_of_a_berkovich_tip(expect, tmp_path):
    """As rows of numbers and as a field, 10 pixels in a cell. Seen: .06 %."""
    exact = harness.run({**SPACE, "indenter": "berkovich"}).history
    heights = berkovich_heights(161, 16.1)
    numpy.savetxt(tmp_path / "map.txt", heights[::-1])
    write_field(tmp_path / "map.gsf", heights, 16.1)
    loads = [harness.run({**SPACE, "indenter": "height_map", **more}).history["load"][-1] for more in (
        {"indenter_map": tmp_path / "map.txt", "indenter_map_size": "16.1,16.1"}, {"indenter_map": tmp_path / "map.gsf"})]
    expect("load of a map of a Berkovich tip over that of the tip", loads[0] / exact["load"][-1], near=1, tolerance=0.003)
    expect("load of a field over that of rows of numbers", loads[1] / loads[0], near=1, tolerance=1e-4)


def test_tilt(expect):
    """Seen: 4e-14."""
    loads = [harness.run({**SPACE, "indenter": "berkovich", "indenter_tilt": (3, side)}).history["load"] for side in (90, -90)]
    expect("load with a tilt to one side of a plane of symmetry less that to the other, of it", numpy.max(numpy.abs(loads[1] - loads[0])) / loads[0].max(),
           at_most=1e-9)


# ---- small unloadings ----

def test_small_unloadings(expect):
    """Down to half of the load, at even parts of the loading: what Oliver and Pharr find of an elastic cone is the same at each."""
    history = harness.run({**block(8), "indenter": "cone", "indenter_half_angle": 80, "indenter_depths": 1.4, "indenter_unloadings": 3}).history
    depth = history["depth"]
    for part in (1, 2, 3):
        there = int(numpy.argmax(depth > 1.4 * part / 3 * (1 - 1e-6)))
        ahead = depth[there:] if part == 3 else depth[there:there + int(numpy.argmax(depth[there:] > 1.4 * (part + 0.5) / 3))]
        expect(f"depth to which unloading {part} goes back, of its own", ahead.min() / (1.4 * part / 3), near=0.5**0.5, tolerance=1e-3)
    expect("largest depth", depth.max() / 1.4, near=1, tolerance=1e-9)


# ---- what is refused ----

def test_refusals(expect, tmp_path):
    (tmp_path / "falls.txt").write_text("0 0\n1 2\n2 1\n")
    (tmp_path / "offset.txt").write_text("0 1\n1 2\n2 3\n")
    (tmp_path / "comma.txt").write_text("0;0\n0,5;1\n1;2\n")
    (tmp_path / "empty.txt").write_text("")
    hill = tmp_path / "hill.txt"
    numpy.savetxt(hill, -berkovich_heights(21, 2.1))
    (tmp_path / "short.gsf").write_bytes(b"Gwyddion Simple Field 1.0\nXRes = 9\nYRes = 9\nXReal = 1\nYReal = 1\nXYUnits = m\nZUnits = m\n\0\0")
    (tmp_path / "units.gsf").write_bytes(b"Gwyddion Simple Field 1.0\nXRes = 9\nYRes = 9\nXReal = 1\nYReal = 1\nXYUnits = m\nZUnits = nm\n\0\0")
    small = tmp_path / "small.txt"
    numpy.savetxt(small, berkovich_heights(21, 0.7))
    area = {"indenter": "area_function", "indenter_area_coefficients": 24.5}
    table = [
        ("area that falls", {**area, "indenter_area_coefficients": "-24.5"}, ["-indenter_area_coefficients"]),
        ("coefficients in nm", {**area, "cell_size": 1, "indenter_area_coefficients": "24.5,-6418"}, ["-indenter_area_coefficients", "coefficients of nm"]),
        ("depths the wrong way", {**area, "indenter_area_depths": "1,0.5"}, ["-indenter_area_depths"]),
        ("deeper than calibrated", {**area, "indenter_area_depths": "0,0.5"}, ["-indenter area_function", "0.5"]),
        ("one face", {**area, "indenter_faces": 1}, ["-indenter_faces"]),
        ("a turn of a tip of revolution", {**area, "indenter_turn": 5}, ["-indenter_turn"]),
        ("no file", {"indenter": "profile", "indenter_profile": "none.txt"}, ["-indenter_profile none.txt", "can be read"]),
        ("empty file", {"indenter": "profile", "indenter_profile": tmp_path / "empty.txt"}, ["-indenter_profile", "not empty"]),
        ("profile that falls", {"indenter": "profile", "indenter_profile": tmp_path / "falls.txt"}, ["-indenter_profile", "row 3"]),
        ("profile with an offset", {"indenter": "profile", "indenter_profile": tmp_path / "offset.txt"}, ["-indenter_profile", "0 0"]),
        ("decimal commas", {"indenter": "profile", "indenter_profile": tmp_path / "comma.txt"}, ["-indenter_profile", "decimal points", "0,5"]),
        ("tip that points up", {"indenter": "height_map", "indenter_map": hill, "indenter_map_size": "2,2"}, ["-indenter_map", "points down"]),
        ("map without a size", {"indenter": "height_map", "indenter_map": hill}, ["-indenter_map_size"]),
        ("map in other units", {"indenter": "height_map", "indenter_map": small, "indenter_map_size": "7e-4,7e-4"}, ["-indenter_map", "both in m"]),
        ("map that ends", {"indenter": "height_map", "indenter_map": small, "indenter_map_size": "0.7,0.7"}, ["-indenter height_map", "known up to"]),
        ("field that ends", {"indenter": "height_map", "indenter_map": tmp_path / "short.gsf"}, ["-indenter_map", "81 numbers"]),
        ("field in nm", {"indenter": "height_map", "indenter_map": tmp_path / "units.gsf"}, ["-indenter_map", "nm"]),
        ("tilt without a direction", {"indenter": "berkovich", "indenter_tilt": "3"}, ["-indenter_tilt"]),
        ("tilt beyond the lowest point", {"indenter": "berkovich", "indenter_tilt": "30,0"}, ["-indenter_tilt", "lowest point"]),
        ("tilt across a side of symmetry", {"indenter": "berkovich", "indenter_tilt": "3,90", "domain_lower": "-8,0,0", "b_lower": "-8,0,0",
                                            "boundary_y_lower": "symmetry"}, ["-indenter berkovich", "mirror image"]),
        ("edge wider than the punch", {"indenter": "flat_punch", "indenter_radius": 3, "indenter_edge_radius": 4}, ["-indenter_edge_radius"]),
        ("a spring that pushes", {"indenter": "berkovich", "indenter_stiffness": -1}, ["-indenter_stiffness"]),
        ("a tip's ratio alone", {"indenter": "berkovich", "indenter_poissons_ratio": 0.1}, ["-indenter_poissons_ratio", "youngs_modulus"]),
        ("a spring and another contact", {"indenter": "berkovich", "indenter_stiffness": 1, "contact": "none"}, ["-contact", "-indenter_stiffness"]),
        ("unloadings of a test with times", {"indenter": "berkovich", "indenter_unloadings": 3, "test_times": "0,1", "indenter_depths": "0,0.5"},
         ["-indenter_unloadings"]),
    ]
    base = {name: value for name, value in SPACE.items() if name != "frames"}
    expect_refused(expect, Table(base, [(name, {**changes}, words) for name, changes, words in table]))


# ---- studies ----

def verify_sneddon(study):
    """Tips of revolution against Sneddon's integral

    An elastic body under tips of eight profiles with eight of the finest cells in the contact's radius: load and radius at rest at the depth
    of Sneddon's solution, in a half space, extrapolated from blocks of 16 and 32 radii, whose sides take as much from the depth as they
    are near.
    """
    def ball(radius, r):
        return r / numpy.sqrt(radius**2 - numpy.minimum(r, 0.9 * radius)**2)

    def conosphere(r):
        return numpy.minimum(ball(R / 2, r), 1 / CONE)  # the ball's slope grows to that of the flank
    parabola = profile_file(study_folder(), lambda r: r**2 / (2 * R), 3 * CELLS, "paraboloid.txt")
    cases = tip_cases(study_folder()) | {
        "ball": ({"indenter": "sphere", "indenter_radius": R}, lambda r: ball(R, r), CELLS),
        "conosphere": ({"indenter": "cone", "indenter_half_angle": ANGLE, "indenter_tip_radius": R / 2}, conosphere, CELLS),
        "cone": ({"indenter": "cone", "indenter_half_angle": ANGLE}, lambda r: numpy.full_like(r, 1 / CONE), CELLS),
        "paraboloid": ({"indenter": "profile", "indenter_profile": parabola}, lambda r: r / R, CELLS),
    }
    for name, (tip, slope, radius) in cases.items():
        results = [press(tip, slope, radius, radii) for radii in (16, 32)]
        ratios = [ratios_of(result, slope, radius) for result in results]
        for k, (what, limit) in enumerate((("load", 0.01), ("radius", 0.015))):
            study.expect(f"{name}: {what}, of Sneddon's", 2 * ratios[1][k] - ratios[0][k], near=1, tolerance=limit)
        exact = [sneddon(slope, a) for a in numpy.linspace(0.1, 1, 40) * radius]
        plot_loads(study, name, results[1], *zip(*exact))
    round_punch(study)


def plot_loads(study, name, result, depths, loads):
    """Load over depth on the larger block, and Sneddon's on a half space; loads over E*."""
    history = result.history
    study.plot(f"{name}: load over depth", "depth (cells)", "load (E* of a cell squared)",
               page.curve("block of 32 radii", history["depth"], history["load_quasi_static"] / MODULUS),
               page.curve("Sneddon, half space", depths, loads, "reference"))


def round_punch(study):
    """The same of a flat punch, whose load is 2 E* a h: the radius is given, and so is the depth."""
    depth, results = CELLS / 80, []
    for radii in (16, 32):
        results.append(harness.run({**block(radii), "indenter": "flat_punch", "indenter_radius": CELLS, "indenter_depths": depth}))
    loads, widths = zip(*(deepest(result, depth) for result in results))
    small, large = (load / (2 * MODULUS * CELLS * depth) for load in loads)
    study.expect("flat punch: load, of 2 E* a h", 1 / (2 / large - 1 / small), near=1, tolerance=0.01)  # compliances add
    study.expect("flat punch: radius, of its own", widths[1] / CELLS, near=1, tolerance=0.015)
    plot_loads(study, "flat punch", results[1], [0, depth], [0, 2 * CELLS * depth])


def study_folder():
    """Where files of a study's tips are."""
    folder = harness.ROOT / "output" / "verify" / "tips"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def verify_tilted_berkovich(study):
    """A Berkovich tip that leans

    By 1 and 3 degrees toward a face and toward an edge, in an elastic body: load at a depth of 1.6 of the coarse cells, where the contact is
    seven of them wide, against that on cells half as large; and with a tilt to either side of a plane of symmetry.
    """
    case = {**SPACE, "indenter": "berkovich", "indenter_depths": 1.6}
    for angle in (0, 1, 3):
        for toward in (0, 180) if angle else (0,):
            loads = [harness.run({**case, "indenter_tilt": (angle, toward), "cell_size": cell}, ranks=harness.up_to(2)).history["load"][-1] for cell in (1, 0.5)]
            study.expect(f"{angle} degrees toward {'an edge' if toward else 'a face'}: load, of that on cells half as large", loads[0] / loads[1], near=1,
                         tolerance=0.02)
    left, right = (harness.run({**case, "indenter_tilt": (3, side)}, ranks=harness.up_to(2)).history["load"] for side in (90, -90))
    study.expect("tilt to either side: difference of loads, of the largest", numpy.max(numpy.abs(left - right)) / left.max(), at_most=1e-9)
