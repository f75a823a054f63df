"""Checkpoints: nothing damaged or senseless is taken."""
import math
import os
import random
import shutil
import time

import h5py
import numpy
import pytest

from safety import BLOCK, ended, refused, succeeds

TINY = {**BLOCK, "domain_upper": "8,8", "block_upper": "4,4", "block_points_per_cell": "1", "block_velocity": "1,1", "max_steps": "8",
        "loads": "p", "p_side": "x_upper", "p_times": "0", "p_pressures": "0"}
NESTED = {**TINY, "levels": "2", "level_1_lower": "2,2", "level_1_upper": "6,6"}


def checkpoint_of(case, folder, step=4, ranks=1):
    succeeds({**case, "checkpoint_interval": str(step), "max_steps": str(step + 2)}, folder, ranks)
    return folder / f"checkpoint_{step:06d}.h5"


def gon(centre, vertices, radius):
    angles = [2 * math.pi * k / vertices for k in range(vertices)]
    return ",".join(f"{centre + radius * math.cos(a):.15g},{centre + radius * math.sin(a):.15g}" for a in angles)


def test_a_checkpoint_of_a_long_case(tmp_path):
    """More text than an attribute of HDF5 holds."""
    case = {name: value for name, value in BLOCK.items() if not name.startswith(("block", "bodies"))}
    one = {"bodies": "a", "a_shape": "polygon", "a_vertices": gon(6, 1772, 4)}
    two = {"bodies": "a,b", "a_shape": "polygon", "b_shape": "polygon", "a_vertices": gon(3, 900, 2.5), "b_vertices": gon(9, 900, 2.5)}
    for name, bodies in (("one", one), ("two", two)):
        file = tmp_path / f"{name}.opts"
        file.write_text("".join(f"-{option} {value}\n" for option, value in bodies.items()))
        long = {"options_file": file, **case, "max_steps": "20", "checkpoint_interval": "10"}
        succeeds(long, tmp_path / name)
        succeeds({**long, "restart": tmp_path / name / "checkpoint_000010.h5"}, tmp_path / name)
        assert len((tmp_path / name / "history.csv").read_text().splitlines()) == 22


def contents_of(path):
    """All that a checkpoint says: datasets and attributes by name."""
    found = {}

    def note(name, thing):
        for key, value in thing.attrs.items():
            found[name, key] = numpy.asarray(value).tobytes()
        if isinstance(thing, h5py.Dataset):
            found[name] = (thing.shape, thing[...].tobytes())

    with h5py.File(path, "r") as file:
        note("/", file)
        file.visititems(note)
    return found


def test_flipped_bits(tmp_path):
    """No flip of a bit passes and changes anything; what HDF5 alone finds is looked at here, and some are given to the program."""
    path = checkpoint_of(TINY, tmp_path / "made")
    data, whole, damaged = path.read_bytes(), contents_of(path), tmp_path / "damaged.h5"
    choice, taken, found = random.Random(3), [], []
    for number in range(400):
        place = choice.randrange(4096) if number % 2 else choice.randrange(len(data))
        changed = bytearray(data)
        changed[place] ^= 1 << choice.randrange(8)
        damaged.write_bytes(changed)
        try:
            same = contents_of(damaged) == whole
        except Exception:
            same = None
        if same is False:
            taken.append(place)
        elif same is None:
            found.append(bytes(changed))
    assert not taken, f"taken with changes: bytes {taken}"
    assert len(found) > 130
    for number, changed in enumerate(choice.sample(found, 20)):
        damaged.write_bytes(changed)
        refused({**TINY, "restart": damaged}, tmp_path / "out", f"-restart {damaged}: must ", ranks=3 if number % 10 == 0 else 1)
    assert not (tmp_path / "out").exists()


def cut_files(data):
    return [b"", data[:1], data[:100], data[: len(data) // 2], data[:-1], data[:-100], b"x" * len(data), data[512:]]


def test_cut_files_and_other_things(tmp_path):
    path = checkpoint_of(TINY, tmp_path / "made")
    damaged = tmp_path / "damaged.h5"
    for data in cut_files(path.read_bytes()):
        damaged.write_bytes(data)
        refused({**TINY, "restart": damaged}, tmp_path / "out", "must be a whole checkpoint")
    os.mkfifo(tmp_path / "pipe")
    for other in (tmp_path, tmp_path / "pipe", "/dev/null", "/dev/zero", tmp_path / "gone"):
        refused({**TINY, "restart": other}, tmp_path / "out", "must be a whole checkpoint")


def scalar(name, place, value, key=None):
    """(label, change): one number of a dataset or of an attribute."""
    def change(file):
        if key:
            values = numpy.array(file[name].attrs[key])
            values.flat[place] = value
            file[name].attrs[key] = values
        else:
            values = file[name][...]
            values.reshape(-1)[place] = value
            file[name][...] = values
    return f"{name} {key or ''} {place} = {value}", change


def reshaped(name, make):
    """A dataset of another shape or type."""
    def change(file):
        values = make(file[name][...])
        del file[name]
        file.create_dataset(name, data=values)
    return f"{name} reshaped", change


def hollow(name, shape, kind="f8"):
    """A dataset that takes no room in the file; None in its shape: as long as it was."""
    def change(file):
        sizes = [size or file[name].shape[axis] for axis, size in enumerate(shape)]
        del file[name]
        file.create_dataset(name, shape=sizes, dtype=kind, chunks=tuple(min(1024, size) for size in sizes))
    return f"{name} of {shape} without data", change


def attribute(name, key, value):
    def change(file):
        file[name].attrs[key] = value
    return f"{name} {key} = {value}"[:60], change


def gone(name, key=None):
    def change(file):
        if key:
            del file[name].attrs[key]
        else:
            del file[name]
    return f"no {name} {key or ''}", change


def every_point(name, value):
    def change(file):
        file[name][...] = value
    return f"{name} all {value}", change


def twice(file):
    for name, data in list(file["level_0"].items()):
        if isinstance(data, h5py.Dataset) and name not in ("counts", "columns", "rows", "ranks", "pressures", "pressure_keys"):
            values = numpy.concatenate([data[...], data[...]])
            del file["level_0"][name]
            file["level_0"][name] = values
    file["level_0/counts"][...] *= 2


def handmade():
    """Checkpoints with right checksums and senseless contents."""
    bad = (math.nan, math.inf, -math.inf, 1e300, -1e300)
    for name in ("position", "velocity", "stress", "deformation_gradient", "short_wave_stress", "mass", "initial_half_size",
                 "initial_position"):
        for value in bad:
            if math.isfinite(value) and name in ("velocity", "stress", "short_wave_stress", "initial_half_size", "initial_position"):
                continue  # large, but a state
            yield scalar(f"level_0/{name}", 3, value)
    for name in ("velocity", "stress", "deformation_gradient"):
        yield every_point(f"level_0/{name}", math.nan)
    for value in (-1, -0.6, 8.6, 9, 1e3, 1e9, 2**31, 2**40, -2**31):
        yield scalar("level_0/position", 0, value)
        yield scalar("level_0/position", 1, value)
    for value in (0, -1, 1e-320, 1e6):
        yield scalar("level_0/mass", 1, value)
    for value in (0, -0.5):
        yield scalar("level_0/initial_half_size", 1, value)
    for place, value in ((0, -1), (0, 0), (3, -1), (3, 0)):
        yield scalar("level_0/deformation_gradient", place, value)
    for value in (1, 7, -1, 2**31 - 1, -2**31):
        yield scalar("level_0/body", 2, value)
    for value in (-1, 2**62, -2**63, 2**63 - 1):
        yield scalar("level_0/id", 0, value)
    yield reshaped("level_0/id", lambda v: numpy.concatenate([v[1:2], v[1:]]))
    yield every_point("level_0/id", 5)
    for value in (-1, -2**31, 16):
        yield scalar("level_0/faces", 0, value)
    for value in (math.nan, -0.1, math.inf):
        yield scalar("level_0/load_share", 5, value)
    for value in (3, 0, -1, 17, 1e10, 1e300, math.nan, math.inf, 15.5, 2**31):
        yield scalar("level_0/counts", 0, value)
    yield reshaped("level_0/counts", lambda v: numpy.concatenate([v, v]))
    yield reshaped("level_0/counts", lambda v: v[:0])
    yield "all points twice", twice
    for name in ("id", "position", "velocity", "stress", "deformation_gradient", "short_wave_stress", "mass", "initial_half_size",
                 "initial_position", "body", "faces"):
        yield reshaped(f"level_0/{name}", lambda v: v[:-1])
        yield reshaped(f"level_0/{name}", lambda v: numpy.concatenate([v, v]))
        yield reshaped(f"level_0/{name}", lambda v: v[:0])
        yield reshaped(f"level_0/{name}", lambda v: v.reshape(v.shape + (1,)))
        yield reshaped(f"level_0/{name}", lambda v: v.astype("i2" if v.dtype.kind == "i" else "f4"))
        yield gone(f"level_0/{name}")
    yield reshaped("level_0/mass", lambda v: v.astype("i8"))
    yield reshaped("level_0/id", lambda v: v.astype("f8"))
    yield reshaped("level_0/body", lambda v: numpy.array([b"x"] * len(v)))
    yield hollow("level_0/id", (2**31,), "i8")
    yield hollow("level_0/id", (2**57,), "i8")
    yield hollow("level_0/position", (2**40, 2))
    for name in ("columns", "rows", "ranks"):
        for value in (0, -1, 5, 1e9, 1e12, math.nan, math.inf, 1.5):
            if name != "ranks" or value != 0:
                yield scalar(f"level_0/{name}", 0, value)
        yield reshaped(f"level_0/{name}", lambda v: numpy.concatenate([v, v]))
        yield reshaped(f"level_0/{name}", lambda v: v[:0])
        yield hollow(f"level_0/{name}", (2**40,))
        yield gone(f"level_0/{name}")
    for place, values in enumerate(((0, -1, 3, 5, 1e300, math.nan), (-1, 2, math.nan, math.inf), (0, -1, math.nan, math.inf), (2, -1, math.nan, 0.5))):
        for value in values:
            yield scalar("level_0", place, value, "pace")
    yield attribute("level_0", "pace", [0.0])
    yield attribute("level_0", "pace", "fast")
    yield gone("level_0", "pace")
    for place, values in enumerate((
            (0, -1, math.nan, math.inf), (0, -1, math.nan, math.inf, 1e9), (0, -1, math.nan), (-1, math.nan, math.inf),
            (0, 2, math.nan), (0, -1, math.nan, math.inf, 1e300), (0, -1, 0.5, 5, 1e300, math.nan, 2**54),
            (-1, 0.5, 1e300, 1e9, math.nan), (0, -1, math.nan, math.inf, 5), (0, 15, 17, 1e300, math.nan, -16),
            (-1, 1, math.nan, 1e300), (math.nan, math.inf), (-1, 1e9, math.nan))):
        for value in values:
            yield scalar("/", place, value, "state")
    yield attribute("/", "state", [1.0, 2.0])
    yield attribute("/", "state", numpy.zeros(2000))
    yield gone("/", "state")
    for place, value in ((0, 1), (0, math.nan), (1, math.nan), (2, math.inf)):
        yield scalar("/", place, value, "copies")
    yield gone("/", "copies")
    for place in (0, 3, 12, 14):
        for value in (math.nan, math.inf):
            yield scalar("totals", place, value)
    for value in (-1, 0.5, 1e300):
        yield every_point("totals", value)  # also what is a count
    yield reshaped("totals", lambda v: v[:, :-1])
    yield reshaped("totals", lambda v: v[:0])
    yield reshaped("totals", lambda v: numpy.concatenate([v, v]))
    yield hollow("totals", (2**57, None))
    yield hollow("totals", (2**40, None))
    yield gone("totals")
    for name in ("pressures", "pressure_keys"):
        yield reshaped(f"level_0/{name}", lambda v: numpy.ones(3))
        yield hollow(f"level_0/{name}", (2**40,))
        yield gone(f"level_0/{name}")
    yield reshaped("identity", lambda v: v[:0])
    yield reshaped("identity", lambda v: v[:-1])
    yield hollow("identity", (2**50,), "u1")
    yield gone("identity")
    yield gone("level_0")
    for value in (9, 8, 0, -1, 1e300):
        yield attribute("/", "format_version", float(value))
    yield attribute("/", "format_version", math.nan)
    yield attribute("/", "format_version", "seven")
    yield gone("/", "format_version")


def handmade_levels():
    """The same for what only levels have."""
    for value in (math.nan, math.inf):
        yield scalar("border_state_0", 0, value)
    yield reshaped("border_state_0", lambda v: v[:-1])
    yield reshaped("border_state_0", lambda v: v[:0])
    yield reshaped("border_state_0", lambda v: numpy.concatenate([v, v]))
    yield hollow("border_state_0", (2**40,))
    yield gone("border_state_0")
    for value in (math.nan, -10, 1e300, 20):
        yield scalar("level_1/position", 0, value)
    yield scalar("level_1", 0, 4, "pace")
    yield gone("level_1")
    yield gone("level_1/stress")

    def shared(file):
        file["level_1/id"][0] = file["level_0/id"][0]
    yield "a number on both levels", shared


def wrong_of_handmade(case, whole, variants, tmp_path, ranks):
    """What went wrong with each variant that was not refused in one line."""
    wrong = []
    for number, (label, change) in enumerate(variants):
        damaged = tmp_path / f"handmade_{ranks}.h5"
        shutil.copy(whole, damaged)
        with h5py.File(damaged, "a", libver="latest") as file:
            change(file)
        begin = time.time()
        status, lines = ended({**case, "restart": damaged}, tmp_path / "out", ranks)
        if status <= 0 or len(lines) != 1 or not lines[0].startswith(f"mlgimp: error: -restart {damaged}: must ") or time.time() - begin > 10:
            wrong.append(f"{label}: status {status}, {lines[:2]}")
    assert not (tmp_path / "out").exists() or wrong
    return wrong


def wrong_on_ranks(tmp_path, every, on_three):
    """The same of each `every`-th variant on one rank, and of each `on_three`-th on three, as one and as three ranks have written them."""
    variants = list(handmade())
    assert len(variants) >= 200
    whole = checkpoint_of(TINY, tmp_path / "made")
    by_three = checkpoint_of({**TINY, "points_per_rank": "1"}, tmp_path / "three", ranks=3)
    return (wrong_of_handmade(TINY, whole, variants[::every], tmp_path, 1)
            + wrong_of_handmade(TINY, whole, variants[::on_three], tmp_path, 3)
            + wrong_of_handmade({**TINY, "points_per_rank": "1"}, by_three, variants[on_three // 2 :: on_three], tmp_path, 3))


def test_handmade_checkpoints(tmp_path):
    assert not wrong_on_ranks(tmp_path, 20, 100)


@pytest.mark.alone
def verify_handmade(study, tmp_path):
    """Checkpoints with senseless contents.

    Numbers, shapes and types that no run would write, with right checksums: each must be refused by one line on one rank, and every fourth on three.
    """
    wrong = wrong_on_ranks(tmp_path, 1, 4)
    study.expect(f"checkpoints with senseless contents that are taken, of {len(list(handmade()))}", len(wrong), at_most=0)


def test_handmade_checkpoints_of_levels(tmp_path):
    whole = checkpoint_of(NESTED, tmp_path / "made")
    assert not wrong_of_handmade(NESTED, whole, handmade_levels(), tmp_path, 1)
    assert not wrong_of_handmade(NESTED, whole, list(handmade_levels())[::8], tmp_path, 3)


def test_no_checkpoint_of_a_failed_state(tmp_path):
    """What is there when a run fails has sound points, and a run goes on from it; the line names it."""
    case = {**BLOCK, "domain_upper": "20,20", "al_youngs_modulus": "1e7", "block_lower": "4,4", "block_upper": "12,12", "loads": "p",
            "p_side": "y_upper", "p_times": "0,0.1", "p_pressures": "0,2e8", "end_time": "1", "history_interval": "1000",
            "checkpoint_interval": "1", "frames": "200", "max_steps": "2000"}
    line = refused(case, tmp_path / "o", "checkpoint")
    last = sorted((tmp_path / "o").glob("checkpoint_*.h5"))[-1]
    assert f"checkpoint {int(last.stem[-6:])} are kept" in line
    for path in (tmp_path / "o").glob("*_0*.h5"):
        with h5py.File(path) as file:
            F = file["level_0/deformation_gradient"][:]
            assert numpy.all(numpy.isfinite(F)) and numpy.all(F[:, 0] * F[:, 3] - F[:, 1] * F[:, 2] > 0), path
    refused({**case, "restart": last, "checkpoint_interval": "0"}, tmp_path / "again", "level 0")
