"""The modules that the package needs: where this Python does not have one, a single line says so and what to do, no traceback."""

import importlib
import sys


class MissingModule(ImportError):
    """A module that cannot be imported; its text is one line. Where nothing catches it, that line is all that is printed."""


def need(*names):
    """Imports modules by name, or raises a MissingModule."""
    for name in names:
        try:
            importlib.import_module(name)
        except ImportError as problem:
            print_in_one_line()
            cause = "" if isinstance(problem, ModuleNotFoundError) and problem.name == name else f" that works ({first_line(problem)})"
            raise MissingModule(f"{sys.executable} has no module {name}{cause}: take /usr/bin/python3 with the packages of `make deps`, or "
                                f"{sys.executable} -m pip install numpy scipy h5py matplotlib") from None


def first_line(problem):
    """Returns the first line of an error's text that is not empty."""
    return next(filter(None, map(str.strip, str(problem).splitlines())), "without a reason")


def print_in_one_line():
    """Lets Python print a MissingModule that nothing catches without a traceback, and all else as before."""
    before = sys.excepthook

    def hook(kind, problem, trace):
        if issubclass(kind, MissingModule):
            print(f"error: {problem}", file=sys.stderr)
        else:
            before(kind, problem, trace)
    sys.excepthook = hook
