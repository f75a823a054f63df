"""A run as an object: everything that is in its result folder, and what follows from it."""

from functools import cached_property
from pathlib import Path

from . import checks, imprint, load_depth, oliver_pharr, results
from .errors import Error
from .needs import need

FIGURES = (("hardness", "hardness_GPa"), ("load over true area", "true_hardness_GPa"), ("modulus", "modulus_GPa"),
           ("modulus with the true area", "true_modulus_GPa"))


def read(folder):
    """Returns the Results of a run in a folder; raises a ResultError where there are none."""
    found = Results(checks.path("folder", folder))
    found.history  # so that a wrong folder is refused here
    return found


def lines_of(run):
    """Yields the lines of a summary of Results; what the run does not have, as a curve or an unloading, is left out, and a line says why."""
    yield f"{run.folder.name}: {run.summary.get('status', results.NOT_ENDED)}, {len(run.frames)} frames in {run.folder}"
    try:
        curve = run.curve()
        yield f"largest load {curve.load.max():.4g} mN, largest depth {1e3 * curve.depth.max():.4g} nm"
        rows = oliver_pharr.analyse(curve)
    except Error as problem:
        yield f"no hardness: {getattr(problem, 'problem', problem)}"
        return
    largest = max(rows, key=lambda row: row["load_mN"])
    errors = largest["expected_error"] or {}
    for label, name in FIGURES:
        if largest[name] == largest[name]:
            yield f"{label} {largest[name]:.3g} GPa" + (f" +- {100 * errors[name]:.2g} % by cells and block" if name in errors else "")
    yield from (f"note: {note}" for note in oliver_pharr.notes_on(rows))
    yield from (f"warning: {line}" for line in (largest["warnings"],) if line)


class Results:
    """The results of a run. Values are SI unless a name or docstring says otherwise; files are read when they are asked for."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def __repr__(self):
        return f"mlgimp.read({str(self.folder)!r}): {self.summary.get('status', results.NOT_ENDED)}, {len(self.frames)} frames"

    def __str__(self):
        """What print() shows of a run: its largest load and depth, hardness and modulus of the unloading from there, and what is doubtful."""
        return "\n".join(lines_of(self))

    def _repr_html_(self):
        """What a notebook shows of a run: load and depth, the last field, hardness and modulus, warnings, its folder."""
        need("matplotlib")
        from .notebook_view import html_of
        return html_of(self)

    @cached_property
    def history(self):
        """The columns of history.csv by name, arrays [rows]: history["load"] in N. history.table() is a pandas.DataFrame where
        there is pandas, else a record array."""
        return results.read_history(self.folder)

    @cached_property
    def summary(self):
        """What summary.json has: status, levels, steps, options, ...; while the run goes on as of its last frame."""
        return results.read_summary(self.folder)

    @cached_property
    def frames(self):
        """The times of the frames, {number: time in s}, in their order."""
        return {number: results.read_time(path) for number, path in results.numbered_frames(self.folder).items()}

    def frame(self, number=-1):
        """Returns the points of all levels of a frame as a dict of arrays by name, [points] or [points][components].

        number: one of frames, or from the end, as -1 for the last. `level` tells the level of each point, position is in m, stress
        in Pa (xx, yy, zz, xy, in space yz, xz too); README.md has the list.
        """
        number = checks.whole("number", number)
        if number < 0:
            if -number > len(self.frames):
                raise Error(f"{self.folder}: no frame {number}; there are {len(self.frames)}")
            number = list(self.frames)[number]
        return results.all_points(results.read_frame(results.find_frame(self.folder, number)).levels)

    def curve(self):
        """Returns the load-depth curve of the whole tip as a load_depth.Curve: um, mN, s."""
        return load_depth.read_run(self.folder)

    def oliver_pharr(self, **constants):
        """Returns the analysis of each unloading by Oliver and Pharr, a list of dicts: load_mN, depth_um, hardness_GPa, ...

        constants: those of oliver_pharr.Constants, as window=(0.5, 0.97), epsilon=0.75, beta=1.03, poisson=0.3, and of a tip that
        is not rigid tip_modulus=1141 (GPa), tip_poisson=0.07; iso=True: by the conventions of ISO 14577, with its numbers. What has no
        meaning is NaN, `warnings` says what makes the figures doubtful, and `expected_error` by how large a share of itself each may
        be off because of the `cells`.
        """
        return oliver_pharr.analyse(self.curve(), oliver_pharr.checked_constants(**constants))

    def imprint(self, frame=None, *, pixel=None, out=None):
        """Returns the imprint in a frame, by default the last one, as an imprint.HeightMap: places x, y and heights in um.

        pixel: its width in um, by default half a finest cell. out: a folder, into which surface.gsf (Gwyddion) and surface.csv are written.
        """
        image = imprint.height_map(self.folder, frame, pixel)
        if out is not None:
            imprint.write(checks.path("out", out), image, f"imprint of {results.case_name(self.folder)}")
        return image

    def plot(self, *names, frame=None, window=None, out=None, log=False, style="screen"):
        """Draws pictures with these names, by default all that the run has, and returns them as {name: matplotlib Figure}.

        names: load_depth, contact_pressure, stress_xx, stress_yy, stress_xy, von_mises_stress, energy, of metals pressure,
        equivalent_plastic_strain and in space plastic_surface, with -test_times test.
        frame: its number, by default the last, and for contact_pressure that of the largest load.
        window: (xmin, xmax, ymin, ymax) in m, also as a text with commas, or "near" for the finest level.
        log: colours by logarithms, of fields that span decades.
        style: "paper" for a figure as wide as a column of a journal, 85 mm, with text of 8 points and no title.
        out: a folder, into which they are written as NAME.png, for paper NAME.pdf, and closed; or of one picture a file .png, .pdf or .svg.
        """
        need("matplotlib")  # only where something is drawn
        from . import pictures
        from .gallery import gallery
        with pictures.looking(style):
            drawn = gallery(self.folder, frame, window, log)
            for name in names:
                if name not in drawn:
                    raise Error(f"{self.folder}: no picture {name}; there are {', '.join(drawn)}")
            figures = {name: drawn[name]() for name in names or drawn}
            if out is not None:
                pictures.save_all(figures, out)
        return figures

    def report(self, path=None):
        """Writes a page about the run, with a slider over the fields of its frames, that any browser shows without a network, and returns
        its path, by default report.html in the folder."""
        need("matplotlib")
        from .run_report import report
        return report(self.folder, path)

    def movie(self, path, component="von_mises_stress", window=None, log=False):
        """Writes a movie of all frames with one colour scale to path, which ends in .gif or .mp4; component: xx, yy, xy,
        von_mises_stress, ...; window and log as in plot."""
        need("matplotlib")
        from .movie import movie
        movie(self.folder, path, component, window, log)
