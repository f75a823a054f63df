"""Which pictures a run has, and how each is drawn."""

import numpy as np

from . import fields, pictures, results, surface

LARGEST_LOAD, AUTO = "largest_load", "auto"  # a frame, and a window
SMALL = 0.1  # of the width of all that there is: a contact that is narrower is a dot in the picture


def gallery(directory, number=None, window=None, is_log=False):
    """Returns the pictures of a result folder as {name: function that draws it and returns a matplotlib Figure}.

    number: frame, by default the last, and for the pressure of contact that of the largest load, which is "largest_load". window: (xmin, xmax,
    ymin, ymax) in m, "near" for the finest level, None for all that there is, "auto" for the first where the contact is small in the
    second, which the title says then. is_log: fields that span decades by logarithms. Of a run without frames there are those of the history.
    """
    number = surface.frame_of_largest_load(directory) if number == LARGEST_LOAD else number
    history, title = results.read_history(directory), pictures.title_of(directory)
    drawn = {}
    if results.has_indenter(history):
        drawn["load_depth"] = lambda: pictures.load_depth(history, title)
    if "test_time" in history:
        drawn["test"] = lambda: pictures.test(history, title)
    if number is None and not results.numbered_frames(directory):
        return drawn | {"energy": lambda: pictures.energy(history, title)}
    panel = fields.read_panel(directory, number)
    if isinstance(window, str) and window == AUTO:
        window = fields.NEAR if is_small(history, panel) else None
        panel = panel._replace(title=f"{panel.title}, near the contact") if window else panel
    window = fields.window_of([panel], window)
    if results.has_indenter(history) and "contact_pressure" in panel.points:
        drawn["contact_pressure"] = lambda: surface.contact_pressure(directory, number)
    for component in components_of(panel):
        name = component if component in fields.SCALARS else f"stress_{fields.spelt(component, panel.axes)}"
        drawn[name] = lambda component=component: fields.fields([panel], component, window, is_log=is_log)
    if panel.axes == "xzy" and is_plastic(panel):
        drawn["plastic_surface"] = lambda: surface.plastic_surface(directory, number)
    drawn["energy"] = lambda: pictures.energy(history, title)
    return drawn


def is_small(history, panel):
    """Whether the contact of a run is never as wide as the share SMALL of a Panel that has finer levels."""
    half = history.get("contact_half_width", np.zeros(1)).max()
    left, right, *_ = fields.extent(panel)
    return bool(len(panel.boxes) > 1 and 0 < 2 * half < SMALL * (right - left))


def components_of(panel):
    """Returns the components that are drawn of a Panel: three stresses, von Mises stress, and of metals the other scalars."""
    scalars = [name for name in fields.SCALARS if name in panel.points and name != "speed" and (name == "von_mises_stress" or is_plastic(panel))]
    return ["xx", "yy", "xy", *scalars]


def is_plastic(panel):
    """Whether any point of a Panel has flowed."""
    return bool(np.any(panel.points.get("equivalent_plastic_strain", 0) > 0))
