"""What cells cannot resolve of a case: thin bodies, contact outside of the finest box. Bodies whose outlines are oblique or
round, which it does resolve."""
import math

import numpy
import pytest

import harness

METAL = {"m_model": "j2", "m_youngs_modulus": 70e9, "m_poissons_ratio": 0.33, "m_density": 2700, "m_yield_stress": 4e8, "m_hardening_modulus": 1e9}
BLOCK = {"geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "8e-6,9.2e-6", "cell_size": 4e-7, "boundary_x_upper": "symmetry",
         "boundary_y_lower": "symmetry", "materials": "m", **METAL, "bodies": "b", "b_lower": "0,0", "b_upper": "8e-6,8e-6", "indenter": "cone",
         "indenter_half_angle": 70.3, "indenter_tip": "0,8e-6", "indenter_times": "0,4e-9", "indenter_velocities": "0,20", "max_steps": 2, "frames": 0}
LEVEL = {"levels": 2, "refinement_ratio": 4, "level_1_lower": "0,5.6e-6", "level_1_upper": "2.4e-6,9.2e-6"}
FILM = {"bodies": "f,b", "b_upper": "8e-6,7.97e-6", "f_lower": "0,7.97e-6", "f_upper": "8e-6,8e-6"}


def warnings(case, word):
    return [line for line in harness.run(case).summary["warnings"] if word in line]


def test_box_beside_the_contact():
    """The load was that of the coarse cells without a word."""
    assert warnings({**BLOCK, **LEVEL}, "does not hold") == []
    line, = warnings({**BLOCK, **LEVEL, "level_1_upper": "2.4e-6,6.8e-6", "level_1_lower": "0,4e-6"}, "does not hold")
    assert line.startswith("-level_1_lower, -level_1_upper:") and "0,8e-06" in line and "4e-07 m of level 0" in line


@pytest.mark.parametrize("case, length, axis, cells", [
    ({**FILM, **LEVEL}, "3e-08", "y", "1.5e-08"),
    ({"b_lower": "0,7.4e-6", "boundary_y_lower": "free"}, "6e-07", "y", "3e-07"),
    ({"b_upper": "3e-7,8e-6", "indenter": "flat_punch", "indenter_radius": 8e-7}, "6e-07", "x", "3e-07")],
    ids=["film", "plate", "pillar"])
def test_thin_bodies_under_the_tip(case, length, axis, cells):
    case = {**BLOCK, **case}
    if case["indenter"] != "cone":
        case.pop("indenter_half_angle")
    line, = warnings(case, "thin where")
    assert f"is {length} m thin where the indenter presses it, from {axis} =" in line and f"cells of at most {cells} m" in line


def test_thin_body_under_a_load():
    case = {name: value for name, value in BLOCK.items() if not name.startswith("indenter")}
    load = {"loads": "p", "p_side": "y_upper", "p_times": "0,1e-6", "p_pressures": "0,1e8"}
    assert warnings({**case, **load}, "thin where") == []
    line, = warnings({**case, **load, "b_lower": "0,7.6e-6", "boundary_y_lower": "free"}, "thin where")
    assert "is 4e-07 m thin where load p presses it, from y = 7.6e-06 to 8e-06" in line


def test_film_that_no_point_fits_in():
    """It was refused by its mass, without why."""
    done = harness.run({**BLOCK, **FILM, "b_upper": "8e-6,7.995e-6", "f_lower": "0,7.995e-6"}, must_succeed=False)
    assert done.status != 0 and "as it is 5e-09 m thin, 0.0125 of a cell of 4e-07 m; take cells of at most 2.5e-09 m there" in done.stderr


SOLID = {"domain_lower": "-30e-6,0", "domain_upper": "30e-6,40e-6", "cell_size": 1e-6, "boundary_y_lower": "symmetry", "boundary_x_lower": "symmetry",
         "boundary_x_upper": "symmetry", "materials": "steel", "steel_youngs_modulus": 210e9, "steel_poissons_ratio": 0.3, "steel_density": 7850,
         "bodies": "block", "block_shape": "polygon", "indenter": "cylinder", "indenter_radius": 10e-6, "quasi_static": "true",
         "indenter_depths": 6e-7, "quasi_static_tolerance": 0.1, "frames": 0}


def tilted(degrees, mirror=1):
    """A block whose surface is tilted; the cylinder touches it."""
    slope = mirror * math.tan(math.radians(degrees))
    lift = 10e-6 * (1 / math.cos(math.radians(degrees)) - 1)
    return {**SOLID, "indenter_tip": [0, 30e-6 + lift],
            "block_vertices": [-30e-6, 0, 30e-6, 0, 30e-6, 30e-6 * (1 + slope), -30e-6, 30e-6 * (1 - slope)]}


def test_tilted_surface(expect):
    """A surface that is oblique to the grid is no stair of points: in plane strain the load is about linear in the depth along its normal."""
    level = harness.run({**tilted(0)})
    for degrees in (5, 15):
        loads = [harness.run(tilted(degrees, mirror)).history["load"].max() for mirror in (1, -1)]
        expect(f"{degrees} degrees: load over that of its mirror image", loads[0] / loads[1], near=1, tolerance=1e-6)
        cosine = math.cos(math.radians(degrees))
        deeper = (6e-7 + 10e-6 * (1 / cosine - 1)) * cosine / 6e-7
        expect(f"{degrees} degrees: load over that of a level surface as deep", loads[0] * cosine / deeper / level.history["load"].max(), near=1, tolerance=0.01)


@pytest.mark.parametrize("geometry", ("plane_strain", "axisymmetric"))
def test_rounded_body(expect, geometry):
    """Half a disk, and half a ball, under a plate: the load hangs on the cells by no more than a contact of as many does on a level surface."""
    case = {"geometry": geometry, "domain_lower": "-24e-6,0" if geometry == "plane_strain" else "0,0", "domain_upper": "24e-6,24e-6",
            "boundary_y_lower": "symmetry", "materials": "m", "m_youngs_modulus": 70e9, "m_poissons_ratio": 0.33, "m_density": 2700,
            "bodies": "body", "body_shape": "disk", "body_center": "0,0", "body_radius": 20e-6, "indenter": "flat_punch",
            "indenter_tip": "0,20e-6", "indenter_times": "0,10e-9,70e-9,80e-9", "indenter_velocities": "0,10,10,0", "damping": 1e8, "end_time": 80e-9}
    case["indenter_width" if geometry == "plane_strain" else "indenter_radius"] = 100e-6
    coarse, fine = (harness.run({**case, "cell_size": cell}).history for cell in (1e-6, 0.5e-6))
    for depth, tolerance in ((100e-9, 0.02), (300e-9, 0.02), (690e-9, 0.01)):  # of 1.3 to 4 cells in half the width of the contact
        loads = [numpy.interp(depth, one["depth"], one["load"]) for one in (coarse, fine)]
        expect(f"load at {depth * 1e9:.0f} nm over that on half the cells", loads[0] / loads[1], near=1, tolerance=tolerance)


def test_disk_on_a_side_of_symmetry(expect):
    """A disk that a held side cuts is the polygon that was needed before."""
    case = {"domain_lower": "0,0", "domain_upper": "12e-6,12e-6", "cell_size": 5e-7, "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry",
            "materials": "m", "m_youngs_modulus": 70e9, "m_poissons_ratio": 0.2, "m_density": 2500, "bodies": "b", "max_steps": 3, "frames": 1,
            "gravity": "0,-1e9"}
    angles = numpy.linspace(0, math.pi / 2, 901)
    corners = [number for angle in angles for number in (10e-6 * math.cos(angle), 10e-6 * math.sin(angle))]
    polygon = harness.run({**case, "b_shape": "polygon", "b_vertices": [0, 0, *corners]}).frame()
    disk = harness.run({**case, "b_shape": "disk", "b_center": "0,0", "b_radius": 10e-6}).frame()
    expect("points", len(disk["mass"]) - len(polygon["mass"]), near=0, tolerance=0)
    sagitta = 10e-6 * (1 - math.cos(math.pi / 3600))
    expect("places, over the height of the circle over the polygon's edges", numpy.abs(disk["position"] - polygon["position"]).max() / sagitta, at_most=1)
