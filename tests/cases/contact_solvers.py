"""Every solver that -contact_ksp_type and -contact_pc_type accept finds the same contact, on any number of ranks."""
import re

import numpy
import pytest

import harness
from ranks import WEDGE

CASE = {**WEDGE, "frames": 0}
SAME = 1e-8  # of the largest load


def accepted(option):
    """The types that the program names when it refuses one."""
    refused = harness.run({**CASE, option: "nonsense"}, must_succeed=False).stderr
    return re.search(r"must be one of (.*)", refused)[1].split(", ")


def expect_same_load(expect, contact, option, types):
    reference = harness.run_once({**CASE, "contact": contact}).history["load"]
    expect(f"{contact}: largest load", numpy.max(reference), at_least=1e-6)
    for kind in types:
        result = harness.run({**CASE, "contact": contact, option: kind}, must_succeed=False)
        load = result.history["load"] if result.status == 0 else []
        if len(load) != len(reference):
            expect.that(f"{contact}, {option} {kind}", False, result.stderr.strip().rpartition("\n")[2] or f"{len(load)} rows for {len(reference)}")
            continue
        expect(f"{contact}, {option} {kind}: load", numpy.max(numpy.abs(load - reference)) / numpy.max(reference), at_most=SAME)


@pytest.mark.parametrize("contact", ("pressure", "point_pressure"))
def test_preconditioners(expect, contact):
    expect_same_load(expect, contact, "contact_pc_type", accepted("contact_pc_type"))


@pytest.mark.parametrize("contact", ("pressure", "point_pressure"))
def test_methods(expect, contact):
    expect_same_load(expect, contact, "contact_ksp_type", accepted("contact_ksp_type"))


def test_tolerance(expect):
    """The load is as good as the gaps are asked to be."""
    exact, loose = harness.run(CASE).history["load"], harness.run({**CASE, "contact_ksp_rtol": "1e-5"}).history["load"]
    expect("load to a tolerance of 1e-5", numpy.max(numpy.abs(loose - exact)) / numpy.max(exact), at_most=1e-5)


@pytest.mark.mpi
def test_wide_contact(expect):
    """A flat punch as wide as the body: eight ranks find the load of one."""
    case = {"domain_lower": "0,0", "domain_upper": "96,14", "cell_size": 1, "boundary_y_lower": "symmetry", "bodies": "block",
            "block_lower": "4,0", "block_upper": "92,12", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3,
            "m_density": 1, "indenter": "flat_punch", "indenter_width": 84, "indenter_tip": "48,12", "indenter_times": 0,
            "indenter_velocities": 0.01, "max_steps": 30, "frames": 0, "points_per_rank": 1}
    alone, result = harness.run(case), harness.run({**case, "contact_monitor": None}, ranks=8)
    solves = re.findall(r"contact: time \S+ unknowns (\d+), pressing (\d+), turns \d+ iterations \d+", result.stdout)
    expect("solves seen", len(solves), at_least=20)
    expect("segments that press, of eight a cell", max((int(pressing) for _, pressing in solves), default=0) / (8 * 84), near=1, tolerance=0.05)
    load = result.history["load"] - alone.history["load"]
    expect("load on 8 ranks against one", numpy.max(numpy.abs(load)) / numpy.max(alone.history["load"]), at_most=1e-9)
