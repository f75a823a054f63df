"""Every solver that -contact_ksp_type and -contact_pc_type accept finds the same contact, on one rank or on all; kernels of pressures."""
import re

import numpy
import pytest

import harness
from ranks import WEDGE

CASE = {**WEDGE, "frames": 0}
SAME = 1e-8  # of the largest load; the tolerance of the solvers is 1e-10


def accepted(option):
    """The types that the program names when it refuses one."""
    refused = harness.run({**CASE, option: "nonsense"}, must_succeed=False).stderr
    return re.search(r"must be one of (.*)", refused)[1].split(", ")


def expect_same_load(expect, contact, option, types):
    reference = harness.run({**CASE, "contact": contact}).history["load"]
    expect(f"{contact}: largest load", numpy.max(reference), at_least=1e-6)
    for kind in types:
        result = harness.run({**CASE, "contact": contact, option: kind}, must_succeed=False)
        load = result.history["load"] if result.status == 0 else []
        if len(load) != len(reference):
            expect.that(f"{contact}, {option} {kind}", False, result.stderr.strip().rpartition("\n")[2] or f"{len(load)} rows for {len(reference)}")
            continue
        expect(f"{contact}, {option} {kind}: load", numpy.max(numpy.abs(load - reference)) / numpy.max(reference), at_most=SAME)


def test_preconditioners(expect):
    types = accepted("contact_pc_type")
    expect.that("direct solvers are accepted", {"lu", "cholesky", "svd"} <= set(types))
    for contact in ("pressure", "point_pressure"):
        expect_same_load(expect, contact, "contact_pc_type", types)


def test_methods(expect):
    """Those for symmetric matrices do not suit point_pressure, whose matrix is not."""
    expect_same_load(expect, "pressure", "contact_ksp_type", accepted("contact_ksp_type"))


def test_solved_on_all_ranks(expect):
    """Three ranks share the equations, or the first has them all; the same run twice is the same to the last digit."""
    alone = harness.run(CASE).history
    for unknowns in (1, 1000):
        first, second = (harness.run({**CASE, "contact_serial_unknowns": unknowns}, ranks=3).history for _ in range(2))
        expect(f"contact_serial_unknowns {unknowns}: load", numpy.max(numpy.abs(first["load"] - alone["load"])) / numpy.max(alone["load"]),
               at_most=1e-9)
        expect.that(f"contact_serial_unknowns {unknowns}: twice the same", all(numpy.array_equal(first[c], second[c]) for c in first))


@pytest.mark.mpi
def test_wide_contact(expect):
    """A flat punch as wide as the body: eight ranks have about as many equations each, and find the load of one."""
    case = {"domain_lower": "0,0", "domain_upper": "96,14", "cell_size": 1, "boundary_y_lower": "symmetry", "bodies": "block",
            "block_lower": "4,0", "block_upper": "92,12", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3,
            "m_density": 1, "indenter": "flat_punch", "indenter_width": 84, "indenter_tip": "48,12", "indenter_times": 0,
            "indenter_velocities": 0.01, "max_steps": 30, "frames": 0, "points_per_rank": 1, "contact_serial_unknowns": 1}
    alone, result = harness.run(case), harness.run({**case, "contact_monitor": None}, ranks=8)
    rows = [int(most) / int(unknowns) for unknowns, most in re.findall(r"unknowns (\d+), at most (\d+) on a rank", result.stdout)]
    expect("solves seen", len(rows), at_least=20)
    expect("largest share of the equations on one of 8 ranks", max(rows, default=1), at_most=0.3)
    load = result.history["load"] - alone.history["load"]
    expect("load on 8 ranks against one", numpy.max(numpy.abs(load)) / numpy.max(alone.history["load"]), at_most=1e-9)


def test_narrow_kernels(expect):
    """The mean gap of a column under a tip of slope tan b is alpha h tan(b)/3: where the load begins, to a step's way."""
    for width in (1, 0.5):
        history = harness.run({**CASE, "contact_width": width, "max_steps": 45, "indenter_velocities": 50}).history
        depth = history["depth"][numpy.argmax(history["load"] > 0)] / 250e-9
        expect(f"contact_width {width}: depth of the first load, cells", depth, near=width / numpy.tan(numpy.radians(70.3)) / 3, tolerance=0.006)
        expect(f"contact_width {width}: largest load", numpy.max(history["load"]), at_least=1e-6)
