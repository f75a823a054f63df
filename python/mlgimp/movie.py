"""Movies of a field: all frames of a run with one colour scale, by matplotlib's writers."""

from pathlib import Path

from matplotlib import animation
from matplotlib import pyplot as plt

from . import checks, fields, results
from .errors import Error, ResultError
from .pictures import DOTS_PER_INCH, in_lines, lab_unit, styled

FRAMES_PER_SECOND = 8


class GifWriter(animation.PillowWriter):
    """Gives each frame 256 colours of its own: with the fixed ones of the format a smooth field has bands."""

    def grab_frame(self, **settings):
        super().grab_frame(**settings)
        self._frames[-1] = self._frames[-1].convert("RGB").quantize(256, dither=0)


ENDINGS = {".gif": GifWriter, ".mp4": animation.FFMpegWriter}


def writer_for(path):
    """Returns matplotlib's writer for a file by its ending."""
    writer = ENDINGS.get(Path(checks.path("path", path)).suffix.lower())
    if writer is None:
        raise Error(f"{path}: the name of a movie must end in {' or '.join(ENDINGS)}")
    if not writer.isAvailable():
        raise Error(f"{path}: ffmpeg is not installed; a movie in a .gif needs none")
    return writer(fps=FRAMES_PER_SECOND)


def scale_of_run(directory, numbers, component, window):
    """Returns the Scale that holds a component in all frames."""
    ends = []
    for number in numbers:
        points = fields.read_panel(directory, number).points
        if component in fields.SCALARS and component not in points:
            raise ResultError(directory, f"its points have no {component}")
        values = fields.values_of(points, component)[fields.in_window(points, window)]
        ends.append(fields.ends_of(values))
    return fields.common_scale(ends, component)


@styled
def movie(directory, path, component="von_mises_stress", window=None, is_log=False):
    """Writes the movie of a component of all frames: xx, yy, zz, xy or one of fields.SCALARS; window and is_log as in fields.fields."""
    fields.check_component(component)
    writer, numbers = writer_for(path), list(results.numbered_frames(directory))
    last = fields.read_panel(directory)
    window = fields.window_of([last], window)
    scale = scale_of_run(directory, numbers, component, window)
    is_log = is_log and fields.spans_decades(fields.values_of(last.points, component))
    figure = fields.fields([last], component, window, scale, is_log=is_log)
    axes, = (each for each in figure.axes if each.images)
    bounds = fields.fitted(window, 1)[0]
    units = lab_unit(bounds, "m"), fields.unit_of([scale.low, scale.high], component)
    try:
        with writer.saving(figure, str(path), DOTS_PER_INCH):
            for number in numbers:
                panel = fields.read_panel(directory, number)
                for drawn in (*axes.images, *axes.patches):  # with the boxes, which may follow the contact; the colour bar stays
                    drawn.remove()
                fields.draw_field(axes, panel, component, bounds, scale, units, is_log)
                axes.set_title(in_lines(panel.title, figure.get_figwidth() - fields.MARGIN[0]))
                writer.grab_frame()
    except (OSError, ValueError) as problem:
        raise ResultError(path, f"cannot be written ({' '.join(str(problem).split())})") from None
    finally:
        plt.close(figure)
