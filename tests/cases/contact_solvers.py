"""Every solver that -contact_ksp_type and -contact_pc_type accept finds the same contact."""
import re

import numpy

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
