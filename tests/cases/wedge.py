"""Quality of the contact in the wedge indentation: noise, first contact, penetration, work against energy."""
import numpy
from harness import run

CELL = 250e-9


def indentation(**options):
    """The paper's wedge on cells of 250 nm, one row of history per step."""
    return run({"cell_size": CELL, "frames": 1, **options}, file="wedge_125nm.opts", ranks=2)


def noise(history, from_depth=100e-9):
    """rms of the load's relative change from step to step, after the trend over nine steps is taken out, and raw."""
    load = history["load"][(history["depth"] > from_depth) & (history["load"] > 0)]
    change = numpy.diff(load) / load[1:]
    trend = numpy.convolve(change, numpy.ones(9) / 9, "same")
    return numpy.sqrt(((change - trend)[4:-4] ** 2).mean()), numpy.sqrt((change**2).mean())


def first_contact(history):
    """Depth at which the load first differs from zero."""
    return history["depth"][numpy.argmax(history["load"] > 0)]


def energy_error(history):
    """|kinetic + strain + dissipated - work| at the end over the most work that the indenter had done."""
    stored = history["kinetic_energy"] + history["strain_energy"] + history["dissipated_energy"]
    work = history["external_work"] + history["indenter_work"]
    return abs(stored[-1] - stored[0] - work[-1]) / abs(history["indenter_work"]).max()


def quality(report, name, history, cell):
    detrended, raw = noise(history)
    report.expect(f"{name}: noise of the load from step to step, rms, trend included", raw, at_most=0.015)
    report.expect(f"{name}: depth at the first load, cells", first_contact(history) / cell, at_most=0.15)
    report.expect(f"{name}: deepest penetration, cells", history["penetration"][-1] / cell, at_most=0.12)
    report.expect(f"{name}: work of the indenter against energy", energy_error(history), at_most=0.01)
    report.expect(f"{name}: mass, relative change", abs(history["mass"][-1] / history["mass"][0] - 1), at_most=1e-12)
    report.expect(f"{name}: points lost", history["points"][0] - history["points"][-1], near=0, tolerance=0)


def test_wedge(report):
    result = indentation()
    quality(report, "wedge, 250 nm cells", result.history, CELL)
    report.expect("wedge: steps that fell back to the diagonal", result.summary["contact_fallbacks"], near=0, tolerance=0)


def test_unloading(report):
    """Elastic contact: the load goes back to zero on unloading, and nothing pulls."""
    history = run({"cell_size": 500e-9, "frames": 0, "indenter_max_depth": 300e-9, "indenter_unload_velocity": 40.0},
                  file="wedge_125nm.opts", ranks=2).history
    report.expect("unloading: least load over the greatest", history["load"].min() / history["load"].max(), at_least=0)
    report.expect("unloading: load at the end over the greatest", history["load"][-1] / history["load"].max(), at_most=0.01)
    report.expect("unloading: deepest, nm", history["depth"].max() * 1e9, near=300, tolerance=1)
    report.expect("unloading: work against energy", energy_error(history), at_most=0.01)


def test_variants(report):
    """Eq. 11 as printed comes late and multi-mesh contact early, as docs/verification.md tells."""
    depths = {}
    for method in ("pressure", "point_pressure", "multimesh"):
        history = indentation(contact=method, indenter_max_depth=150e-9).history
        depths[method] = first_contact(history) / CELL
        report.note(f"wedge, {method}: first load at {depths[method]:.3f} cells, noise {noise(history, 50e-9)[1]:.3g}", True)
    report.expect("Eq. 11 makes contact late: first load, cells", depths["point_pressure"], at_least=0.2)
    report.expect("multi-mesh contact is early: first load, cells", depths["multimesh"], at_most=0.01)


def verify_wedge_quality(report):
    for name, cell in (("wedge_500nm", 500e-9), ("wedge_125nm", 125e-9), ("wedge_62nm", 62.5e-9)):
        quality(report, name, run({"frames": 1}, file=name + ".opts", ranks=2).history, cell)
