"""mlgimp from Python: run a case, read its results, indent a material, fit constants to a measured curve or to its hold.

    import mlgimp
    test = mlgimp.indent("j2", youngs_modulus=70e9, poissons_ratio=0.33, density=2700, yield_stress=400e6, depth=200e-9)
    test.history["load"], test.frame(-1)["stress"], test.oliver_pharr()[0]["hardness_GPa"]
    test.plot("load_depth", out="pictures")

All values are SI; curves and the analysis of unloadings are in the units of the laboratory (um, mN, GPa), which their names say.
"""

from .needs import need

need("numpy", "scipy", "h5py")  # before the modules that import them

from . import csm, imprint, presets, uncertainty
from .calibration import calibrate
from .case_check import check
from .creep_fits import fit_creep
from .errors import Error, Interrupted, ResultError, RunError
from .fitting import fit
from .folder import Results, read
from .indentation import indent
from .instrument import Tip
from .load_depth import read_measured, read_tests
from .program import run
from .sweeps import sweep

__all__ = ["Error", "Interrupted", "ResultError", "RunError", "Results", "Tip", "calibrate", "check", "fit", "fit_creep", "indent", "read",
           "read_measured", "read_tests", "run", "sweep"]
