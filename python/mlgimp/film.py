"""Fields over the frames of a run for the viewer of a page: places and values as whole numbers of few bytes, compressed, in base64."""

import base64
import zlib
from collections import namedtuple

import numpy as np
from matplotlib import colormaps

from . import fields, outlines, results
from .errors import ResultError
from .parallelograms import edges_of
from .pictures import lab_unit

Shot = namedtuple("Shot", "time words ids position edges values boxes tip near")
Shot.__doc__ = """What the viewer shows of a frame: its time (s) and that with depth and load as text; of the points ids [n], position
[n][2] (m), edges [n][side][2] (m, see parallelograms.edges_of) and {component: values [n] in SI}; boxes of levels
[levels][lower, upper][2] (m); the place of the tip [2] (m) or
None; and the window (xmin, xmax, ymin, ymax) in m near the contact."""
Film = namedtuple("Film", "values left_out")
Film.__doc__ = "What the script of the page reads, a dict for JSON (viewer.js); and what it does not have of the run, a list of texts."

COMPONENTS = "von_mises_stress", "pressure", "xx", "yy", "zz", "xy", "equivalent_plastic_strain", "temperature", "speed"  # most wanted first
LARGEST = 4_000_000  # bytes of places and values in base64
MOST_FRAMES = 120
MOST_POINTS = 2_000_000  # of all frames together, which are held in memory; of fewer what is packed fills LARGEST
FEWEST_FRAMES, FEWEST_FIELDS = 8, 3  # while something else can be left out
PARTS = 32  # of the smallest half size of a point: places are rounded to one
CODES = 4095  # steps of a field between the ends of its scale
PLACE_BYTES, VALUE_BYTES = 4, 2
REACH = 4.0  # largest half widths of the contact that a picture near it shows on each side, where there are no finer levels
SAFE = 0.9  # of what would fit by the mean size of frames or points


# ---- what there is ----

def film(directory):
    """Returns the Film of a result folder, with what fits into a page; raises a ResultError where there are no frames."""
    there = results.numbered_frames(directory)
    if not there:
        raise ResultError(directory, "no frames here (-frames 0, or the run has just begun)")
    history, summary = results.read_history(directory), results.read_summary(directory)
    times = [results.read_time(path) for path in there.values()]
    last = fields.read_panel(directory, max(there), is_half=True)
    count = min(MOST_FRAMES, max(FEWEST_FRAMES, MOST_POINTS // len(last.points["position"])))
    chosen = choose(times, count, time_of_largest_load(history))
    panels = (fields.read_panel(directory, list(there)[place], is_half=True) for place in chosen)
    shots = [nearest(shot(panel, times[place], history, summary), MOST_POINTS // FEWEST_FRAMES) for panel, place in zip(panels, chosen)]
    return fitting(shots, last, history, len(times))


def time_of_largest_load(history):
    """Returns the time (s) of the largest load in a History; None of a run without an indenter."""
    return history["time"][np.argmax(history["load"])] if results.has_indenter(history) else None


def choose(times, count, largest):
    """Returns the places of at most `count` of some times (s): the first, the last, that next to a time `largest`, None where there is no
    such time, and others at equal distances."""
    needed = {0, len(times) - 1}
    if largest is not None:
        needed.add(int(np.argmin(np.abs(np.array(times) - largest))))
    spare = max(count - len(needed - {0, len(times) - 1}), 2)
    return sorted(needed | set(np.linspace(0, len(times) - 1, min(spare, len(times))).round().astype(int).tolist()))


def shot(panel, time, history, summary):
    """Returns the Shot of a Panel that is not mirrored."""
    points, options = panel.points, summary.get("options", {})
    order = np.argsort(points["id"], kind="stable") if "id" in points else np.arange(len(points["position"]))
    values = {name: np.nan_to_num(fields.values_of(points, name)[order]).astype(np.float32) for name in COMPONENTS
              if name in fields.STRESS_COLUMN or name in points}
    tip = None if panel.indenter is None else outlines.place_of_tip(history, time, options)[[0, -1]]
    ids = points["id"][order] if "id" in points else order
    return Shot(time, fields.state_at(history, time), ids, points["position"][order], edges_of(points)[order], values, panel.boxes, tip,
                near(panel, tip, history))


def near(panel, tip, history):
    """Returns the window (xmin, xmax, ymin, ymax) in m near the contact: that of the finest level, or of one level around the tip; None where
    neither is known."""
    widths, whole = history.get("contact_half_width", np.zeros(1)), fields.extent(panel)
    if fields.has_axis(history):
        whole[0] = -whole[1]
    if len(panel.boxes) > 1:
        (left, low), (right, high) = panel.boxes[-1]
        margin = 0.1 * max(right - left, high - low)
        window = [(-right if fields.has_axis(history) else left) - margin, right + margin, low - margin, high + margin]
    elif tip is not None and np.nanmax(widths, initial=0) > 0:
        reach = REACH * np.nanmax(widths)
        window = [tip[0] - reach, tip[0] + reach, tip[1] - reach, tip[1] + reach]
    else:
        return None
    return [float(bound(end, limit)) for bound, end, limit in zip((max, min) * 2, window, whole)]


# ---- what fits ----

def fitting(shots, last, history, count):
    """Returns the Film of Shots with what fits into LARGEST; last: the Panel of the last frame; count: how many frames the run has."""
    components = components_of(shots)
    every, points = list(components), len(last.points["position"])
    while True:
        coded = code(shots, components)
        share = LARGEST / sum(len(each) for each in coded.values())
        if share >= 1:
            break
        if len(shots) > FEWEST_FRAMES:
            kept = choose([each.time for each in shots], max(FEWEST_FRAMES, int(SAFE * share * len(shots))), time_of_largest_load(history))
            shots = [shots[place] for place in kept] if len(kept) < len(shots) else shots[::2]
        elif len(components) > FEWEST_FIELDS:
            components = components[:max(FEWEST_FIELDS, min(len(components) - 1, int(SAFE * share * len(components))))]
        else:
            shots = [nearest(each, int(SAFE * share * len(each.ids))) for each in shots]
    left_out = [f"{count - len(shots)} of {count} frames"] * (len(shots) < count)
    absent = [fields.label_in_words(name, last.axes) for name in every if name not in components]
    left_out += [f"the fields {', '.join(absent)}"] * bool(absent)
    left_out += [f"{points - len(shots[-1].ids)} of {points} points, those furthest from the tip"] * (len(shots[-1].ids) < points)
    return Film(described(shots, components, coded, last, fields.has_axis(history)), left_out)


def components_of(shots):
    """Returns the components that all Shots have and that are not the same everywhere."""
    names = [name for name in shots[0].values if all(name in each.values for each in shots)]
    return [name for name in names if max(each.values[name].max() for each in shots) > min(each.values[name].min() for each in shots)
            ] or names[:1]


def nearest(each, count):
    """Returns a Shot with at most so many points, those nearest to the tip, or to the middle of all."""
    if len(each.ids) <= count:
        return each
    centre = each.position.mean(axis=0) if each.tip is None else each.tip
    kept = np.sort(np.argsort(np.linalg.norm(each.position - centre, axis=1), kind="stable")[:count])
    return each._replace(ids=each.ids[kept], position=each.position[kept], edges=each.edges[kept],
                         values={name: values[kept] for name, values in each.values.items()})


# ---- how it is packed ----

def code(shots, components):
    """Returns the places, as "places", and each component of Shots as base64, a dict."""
    start, step = grid_of(shots)
    places = [[*np.rint((each.position - start) / step).T, *np.rint(each.edges / step).reshape(-1, 4).T] for each in shots]
    found = {"places": packed(places, shots, PLACE_BYTES)}
    for name in components:
        scale = scale_of(shots, name)
        values = [[np.clip(np.rint((each.values[name] - scale.low) / (scale.high - scale.low) * CODES), 0, CODES)] for each in shots]
        found[name] = packed(values, shots, VALUE_BYTES)
    return found


def half_sizes(each):
    """Returns the half sizes [n][2] (m) of the points of a Shot."""
    return np.linalg.norm(each.edges, axis=1)


def grid_of(shots):
    """Returns the origin [2] and the step (m) of the whole numbers that places of Shots become."""
    lower = np.min([(each.position - half_sizes(each)).min(axis=0) for each in shots], axis=0)
    return lower, min(half_sizes(each).min() for each in shots) / PARTS


def scale_of(shots, component):
    """Returns the one Scale of a component over all Shots, by the points of the finest level, which are the smallest."""
    ends = []
    for each in shots:
        size = half_sizes(each).max(axis=1)
        ends.append(fields.ends_of(each.values[component][size <= 2 * size.min()]))
    return fields.common_scale(ends, component)


def packed(columns, shots, count):
    """Returns columns of whole numbers, [frames][columns][n], as base64.

    Of a frame with the points of the one before, the differences from that are kept, else those from point to point: both are small. They
    are folded to be >= 0, and of all the first byte stands before all the second, of `count` bytes.
    """
    parts = []
    for place, own in enumerate(columns):
        for column, values in enumerate(own):
            before = columns[place - 1][column] if is_as_before(shots, place) else np.append(0, values[:-1])
            change = (values - before).astype(np.int64)
            folded = np.where(change < 0, -2 * change - 1, 2 * change).astype("<u4")
            parts.append(folded.view(np.uint8).reshape(-1, 4).T[:count].tobytes())
    return base64.b64encode(zlib.compress(b"".join(parts), 6)).decode()


def is_as_before(shots, place):
    """Whether a frame has the same points as the one before."""
    return place > 0 and np.array_equal(shots[place].ids, shots[place - 1].ids)


# ---- what the script reads ----

def described(shots, components, coded, last, is_mirrored):
    """Returns the dict that viewer.js reads; last: the Panel of the last frame."""
    start, step = grid_of(shots)
    ends = [fields.extent(last._replace(points={"position": each.position, "half_size": half_sizes(each)})) for each in shots]
    whole = np.where([True, False] * 2, np.min(ends, axis=0), np.max(ends, axis=0))
    if is_mirrored:
        whole[0] = -whole[1]
    length = lab_unit(whole, "m")
    tip = shots[-1].tip
    return {"axes": last.axes[:2], "length": {"factor": length.factor, "name": length.name}, "start": start.tolist(), "step": step,
            "mirror": is_mirrored, "whole": whole.tolist(), "indenter": None if tip is None else (last.indenter - tip).tolist(),
            "frames": [described_frame(shots, place) for place in range(len(shots))], "places": coded["places"],
            "fields": [described_field(shots, name, coded[name], last.axes) for name in components],
            "colours": {name: colours_of(name) for name in {scale_of(shots, each).colormap for each in components}}}


def described_frame(shots, place):
    """Returns what viewer.js reads about one frame, a dict."""
    each = shots[place]
    return {"time": each.time, "words": each.words, "count": len(each.ids), "same": bool(is_as_before(shots, place)),
            "boxes": each.boxes.reshape(-1, 4).tolist(), "tip": None if each.tip is None else each.tip.tolist(), "near": each.near}


def described_field(shots, component, values, axes):
    """Returns what viewer.js reads about one component, a dict: low and high are in the unit of that name."""
    scale = scale_of(shots, component)
    unit = fields.unit_of([scale.low, scale.high], component)
    return {"name": component, "label": fields.label_in_words(component, axes), "unit": unit.name, "low": scale.low * unit.factor,
            "high": scale.high * unit.factor, "colours": scale.colormap, "odd": component == "xy", "values": values}


def colours_of(name):
    """Returns the 256 colours of a colormap, six letters each."""
    return "".join(f"{red:02x}{green:02x}{blue:02x}" for red, green, blue, _ in colormaps[name](np.arange(256), bytes=True))
