"""What a laboratory finds with a simulated instrument: stiffness over the depth, an elastic tip, and a calibration by fused silica."""
import math

import numpy

import mlgimp
from mlgimp import indentation, load_depth, oliver_pharr, tips

import harness

# A vendor's area function (nm); fused silica, whose flow is taken as perfectly plastic at the stress that gives 10 to 11 GPa.
VENDOR = (32.9049, -6418.303798, 288484.8518, -989287.0625, 103588.5588, 675977.3345)
SILICA = {"youngs_modulus": 72e9, "poissons_ratio": 0.17, "yield_stress": 7e9}
STEEL = {"youngs_modulus": 200e9, "poissons_ratio": 0.3, "yield_stress": 1e9}
WINDOW = 0.1, 0.97  # of an unloading: a run has no drift that would bend its end
BLOCK = 45  # radii of the contact, whose sides make moduli 1.09/45 too large


def indented(constants, depth, tip, law="j2", **more):
    """The folder of a run of mlgimp.indent's case; more: its arguments."""
    groups = indentation.indentation_options(law, tip=tip, depth=depth, cells=8, block=BLOCK, tolerance=0.05, frames=0, **constants, **more)
    options = {name: "true" if value is True else value for group in groups for name, value in group.items()}
    return harness.run({**options, "history_interval": 4}).folder


def figures(folder, **constants):
    """The rows of Oliver and Pharr's analysis of a run."""
    return oliver_pharr.analyse(load_depth.read_run(folder), oliver_pharr.checked_constants(**constants))


def verify_stiffness_over_depth(study):
    """Hardness and modulus over the depth from one run

    A cone in a metal with seven small unloadings on the way (-indenter_unloadings), against a run that is wholly unloaded at each of the seven
    depths.
    """
    case = {"cell_size": 1600e-9, "quasi_static": "true", "frames": 0, "history_interval": 4}
    depths = [400e-9 * k / 7 for k in range(1, 8)]
    wholly = [value for depth in depths for value in (depth, 0.0)]
    runs = [harness.run({**case, **more}, file="cone_metal.opts").folder
            for more in ({"indenter_depths": [400e-9, 0.0], "indenter_unloadings": 7}, {"indenter_depths": wholly})]
    small, whole = (figures(folder, poisson=0.3) for folder in runs)
    study.expect("unloadings", len(small), near=7, tolerance=0)
    for name in ("hardness_GPa", "modulus_GPa"):
        study.expect(f"{name}: largest difference, of its value", max(abs(a[name] / b[name] - 1) for a, b in zip(small, whole)), at_most=0.01)


def verify_elastic_tip(study):
    """An elastic tip

    A cone with the equivalent angle of a Berkovich tip in a steel and a ball on an elastic body, by a diamond (1141 GPa, .07) and by a rigid tip: the
    specimen's modulus by Oliver and Pharr, with the tip's own part taken off.
    """
    cases = {"cone in steel": (STEEL, 300e-9, {"tip": "berkovich"}), "ball on silica": ({**SILICA, "yield_stress": None}, 60e-9, {"tip": "sphere", "radius": 5e-6})}
    for name, (constants, depth, tip) in cases.items():
        law = "j2" if constants["yield_stress"] else "neo_hookean"
        known = {key: value for key, value in constants.items() if value}
        rigid, elastic = (figures(indented(known, depth, law=law, **tip, options=options))[0]
                          for options in ({}, {"indenter_youngs_modulus": 1141e9, "indenter_poissons_ratio": 0.07}))
        study.expect(f"{name}: modulus with an elastic tip, of that with a rigid one", elastic["modulus_GPa"] / rigid["modulus_GPa"], near=1, tolerance=0.01)
        study.figure(f"{name}: reduced modulus, of the same", elastic["reduced_modulus_GPa"] / rigid["reduced_modulus_GPa"])


def verify_calibration(study):
    """A calibration by fused silica

    A vendor's tip on a frame of 3 N/um in fused silica at ten depths from .3 to 5 um: the area function and the frame that scripts/calibrate.py's
    code finds of the curves with the frame in them, whose modulus is known, with that of the model's sides. beta is that of a cone with the
    angle of the tip's flanks, in a run of its own. What is left is Oliver and Pharr's assumption that the hardness is the same at all
    depths: under this tip, whose flanks change their slope, it falls by 4 % from the first depth to the last.
    """
    modulus = 72 * (1 + 1.09 / BLOCK)
    cone = figures(indented(SILICA, 500e-9, mlgimp.Tip("cone", half_angle=72.4)), beta=1, epsilon=0.75, window=WINDOW)[0]
    beta = cone["modulus_GPa"] / modulus
    study.figure("beta of a cone", beta)
    curves = []
    for depth in numpy.geomspace(300e-9, 5e-6, 10):
        curve = load_depth.read_run(indented(SILICA, float(f"{depth:.4g}"), mlgimp.Tip(area_nm=VENDOR, frame=3e6)))
        curves.append(curve._replace(depth=curve.depth + 1e-3 / 3 * curve.load, tip=None))
    found = mlgimp.calibrate(curves, modulus=modulus, poisson=0.17, tip_modulus=math.inf, tip_poisson=0, beta=beta, window=WINDOW)
    depths = 1e-3 * numpy.geomspace(*found.depths, 50)
    ratio = tips.tip_of_function(found.coefficients).area(depths) / tips.tip_of_function(VENDOR).area(depths)
    study.expect("frame, of that of the run", found.frame / (1 / 3), near=1, tolerance=0.03)
    study.expect("area over that of the tip, largest difference", numpy.max(numpy.abs(ratio - 1)), at_most=0.02)
