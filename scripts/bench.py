#!/usr/bin/env python3
"""Speed of mlgimp on this machine, in units of what the machine can do.

usage: scripts/bench.py        after `make bench` has built bin/mlgimp and bin/bench_machine

The yardstick is the memory floor: the time in which what two sweeps a step need of the points' fields streams through
memory (docs/performance.md). Beside it stand two limits of each variant as it is written: the time in which the bytes that
its sweeps move stream, and that in which the core issues its instructions at six a cycle. Bandwidth and program are measured in turn, since the speed of a shared machine drifts. Each
figure is a median, with least and greatest. The row of two runs at once, which know nothing of each other, tells what two
ranks could gain. Results go to a temporary folder.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser
from log_view import LogView

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
FLOOR_BYTES = 296  # of a point and step: what points to grid reads, 120, and what the way back reads and writes, 176
USL_BYTES, GOAL_BYTES = 1632, 2448  # over the bandwidth: the time that a step may take, with USL and in general
MOVED_BYTES = {"USL": 320, "default": 448, "XPIC(2)": 402}  # of a point and step, by the sweeps as they are
INSTRUCTIONS = {"USL": 345, "default": 525, "XPIC(2)": 451}  # of a point and step, of the AVX2 build by callgrind
ISSUED_PER_CYCLE = 6
REPETITIONS = 5
FIVE_LEVEL_STEPS = 1260  # of level 0 in the whole run of multiscale_5level.opts
FIVE_LEVEL_GROWTH = 1.1  # time of that run over the time of as many steps like its first: contact and transfer grow
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe")

DEFAULT = {}
USL = {"stress_update": "usl", "short_wave_viscosity": "0,0"}
XPIC = {"short_wave_viscosity": "0,0", "xpic_fraction": 0.02}
METAL = {"m_model": "j2", "m_yield_stress": 11, "m_hardening_modulus": 1e5}


def machine():
    """Triad bandwidth in GB/s, multiply-add rate in Gflop/s and clock in GHz of one core, now."""
    done = subprocess.run([str(ROOT / "bin/bench_machine")], capture_output=True, text=True, check=True)
    return tuple(float(word) for word in done.stdout.split())


def block(cells, steps, **other):
    """Options of a block of cells x cells under gravity, four points a cell, moving and straining; then others."""
    edge = cells + 10
    values = {"domain_lower": "0,0", "domain_upper": f"{edge},{edge}", "cell_size": 1, "materials": "m",
              "m_youngs_modulus": 1e7, "m_poissons_ratio": 0.3, "m_density": 1000, "bodies": "b", "b_lower": "5,5",
              "b_upper": f"{cells + 5},{cells + 5}", "b_velocity": "0.3,0.2", "gravity": "0,-5", "max_steps": steps,
              "frames": 0, "history_interval": 1000000, "monitor": "false", **other}
    return [word for name, value in values.items() for word in (f"-{name}", str(value))]


def block_in_space(cells, steps):
    """The same in space, eight points a cell, with two cells around it."""
    return block(cells, steps, geometry="3d", domain_lower="0,0,0", domain_upper=f"{cells + 4},{cells + 4},{cells + 4}",
                 b_lower="2,2,2", b_upper=f"{cells + 2},{cells + 2},{cells + 2}", b_velocity="0.3,0.2,0.1", gravity="0,-5,0")


def case(name, **other):
    """Options of a file of options/, as they stand there but for others."""
    words = [word for option, value in other.items() for word in (f"-{option}", str(value))]
    return ["-options_file", str(ROOT / "options" / f"{name}.opts"), "-monitor", "false", *words]


class Run:
    """One run: its summary, wall time in s from the first step to the last, and what PETSc counted."""

    def __init__(self, options, ranks=1):
        with tempfile.TemporaryDirectory() as folder:
            command = [str(ROOT / "bin/mlgimp"), *options, "-output_dir", f"{folder}/run", "-log_view", f":{folder}/log:ascii_csv"]
            if ranks > 1:
                command = ["mpiexec", "-n", str(ranks), *command]
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, check=False)
            if done.returncode != 0:
                sys.exit(done.stderr)  # else warnings, as shortened cases have few cells in contact
            self.summary = json.loads(pathlib.Path(folder, "run/summary.json").read_text())
            self.log = LogView(f"{folder}/log")
        self.seconds = self.summary["wall_seconds"]
        self.nanoseconds = 1e9 * self.summary["seconds_per_point_step"]

    def percent(self, event):
        """Share of the run's time that its ranks spend in an event on average."""
        return 100 * self.log.total("seconds", event, stage="") / self.log.ranks / self.seconds

    def point_steps(self):
        return sum(level["points"] * level["steps"] for level in self.summary["levels"])

    def imbalance(self):
        """Largest over mean points of a rank, on the level where it is worst."""
        return max(level["imbalance"] for level in self.summary["levels"])


class Spread:
    """Median, least and greatest of repeated figures."""

    def __init__(self, values):
        self.values = list(values)
        self.median = float(np.median(self.values))

    def __str__(self):
        return f"{self.median:.3g} ({min(self.values):.3g} .. {max(self.values):.3g})"


def row(name, figure, unit, goal=None, ratio=None):
    """Prints a row; the ratio is that of figure to goal, so that 1 and less is reached."""
    if goal is not None and ratio is None:
        ratio = figure.median / goal if isinstance(figure, Spread) else figure / goal
    text = str(figure) if isinstance(figure, Spread) else f"{figure:.3g}"
    print(f"{name:40s} {text:28s} {unit:18s} {'' if goal is None else f'{goal:.3g}':8s} "
          f"{'' if ratio is None else f'{ratio:.2f}':6s}".rstrip(), flush=True)


def alternate(cases, repetitions=REPETITIONS):
    """Runs machine and cases {name: options} in turn; the machine's figures and the runs by name, as lists."""
    limits, runs = [], {name: [] for name in cases}
    for _ in range(repetitions):
        limits.append(machine())
        for name, options in cases.items():
            runs[name].append(Run(options))
    return limits, runs


def sweep_rows():
    """Time a point and step of each variant over the memory floor measured beside it."""
    goals = {"USL, 250k points": USL_BYTES / FLOOR_BYTES, "default, 250k points": GOAL_BYTES / FLOOR_BYTES,
             "XPIC(2), 250k points": GOAL_BYTES / FLOOR_BYTES}
    variants = dict(zip(goals, (USL, DEFAULT, XPIC)))
    limits, runs = alternate({name: block(250, 60, **variant) for name, variant in variants.items()})
    for what, unit, figures in zip(("triad", "multiply-add", "clock"), ("GB/s", "Gflop/s", "GHz"), zip(*limits)):
        row(f"{what}, one core", Spread(figures), unit)
    bandwidths, clocks = [limit[0] for limit in limits], [limit[2] for limit in limits]
    row("memory floor, two sweeps", Spread(FLOOR_BYTES / bandwidth for bandwidth in bandwidths), "ns/point-step")
    for name, goal in goals.items():
        times, kind = [run.nanoseconds for run in runs[name]], name.split(",")[0]
        row(name, Spread(times), "ns/point-step")
        row("", Spread(time * bandwidth / FLOOR_BYTES for time, bandwidth in zip(times, bandwidths)), "memory floors", goal)
        for what, least in (("memory", [MOVED_BYTES[kind] / bandwidth for bandwidth in bandwidths]),
                            ("issue", [INSTRUCTIONS[kind] / (ISSUED_PER_CYCLE * clock) for clock in clocks])):
            row(f"    {what} limit, its share of the time", Spread(least), "ns/point-step")
            row("", Spread(100 * limit / time for limit, time in zip(least, times)), "%")
    return runs["default, 250k points"]


def size_rows():
    """The same time at other sizes, and the memory a point takes."""
    cases = {"16k": block(64, 300), "250k": block(250, 30), "1M": block(500, 10)}
    _, runs = alternate(cases, 3)
    for name in ("16k", "1M"):
        ratios = Spread(run.nanoseconds / reference.nanoseconds for run, reference in zip(runs[name], runs["250k"]))
        row(f"{name} against 250k points", ratios, "times", 1.3)
    row("memory of the process, 1M points", largest_process() / 1e6, "bytes/point", 290)
    Run(block_in_space(50, 60))
    row("memory of the process, 1M points, space", largest_process() / 1e6, "bytes/point", 420)


def metal_rows():
    """A metal all of whose points flow over the neo-Hookean law, and what its volume average takes of it.

    The block rests on sides of symmetry under so little gravity that points keep their order in both: in a metal that runs
    out, fewer points share their nodes, which costs time with every law.
    """
    rest = {"b_lower": "0,0", "b_velocity": "0,0", "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry"}
    for size, cells, steps in (("14k", 55, 1500), ("250k", 245, 300)):
        alone = {**METAL, "m_volume_average": "false"}
        _, runs = alternate({law: block(cells, steps, **rest, gravity="0,-0.05", **options)
                             for law, options in (("elastic", {}), ("metal", METAL), ("alone", alone))})
        for name, over, unit, goal in (("metal", "elastic", "neo-Hookean", 1.4), ("metal, its average", "alone", "that without", 1.12)):
            ratio = Spread(one.seconds / other.seconds for one, other in zip(runs["metal"], runs[over]))
            row(f"{name}, {size} points", ratio, unit, goal)


def largest_process():
    """Memory in bytes of the largest run so far."""
    return 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss


def parallel_rows():
    """Speed-up on two ranks, and what they spend on each other: the event of the halo holds the waiting."""
    worth, pairs = [], []
    for _ in range(2 * REPETITIONS):
        worth.append(cores_worth())
        pairs.append([Run(block(250, 60), ranks) for ranks in (1, 2)])
    row("two runs at once, 125k points each", Spread(worth), "cores' worth")
    gain = Spread(one.seconds / two.seconds for one, two in pairs)
    row("two ranks, 250k points", gain, "speed-up", 1.8, 1.8 / gain.median)
    row("two ranks: Halo with waiting, Migrate", Spread(two.percent("Halo") + two.percent("Migrate") for _, two in pairs), "%", 10)


def empty_step_rows():
    """A level step on 16 x 16 cells with 36 points, which take 2 us, divided where there are two ranks."""
    steps = 20000
    for ranks, goal in ((1, 15), (2, 60)):
        quiet = {"domain_upper": "16,16", "b_points_per_cell": 1, "gravity": "0,0", "b_velocity": "0,0", "time_step": 1e-4,
                 "points_per_rank": 1}
        times = [1e6 * Run(block(6, steps, **quiet), ranks).seconds / steps for _ in range(3)]
        row(f"empty level step, {ranks} rank{'s' * (ranks > 1)}", Spread(times), "us", goal)


def share_rows(runs):
    """Shares of the stepping time of what is no sweep."""
    for event, goal in (("Sort", 3), ("Halo", None), ("GridUpdate", None)):
        row(f"share of {event}", Spread(run.percent(event) for run in runs), "%", goal)


def cores_worth():
    """What two runs at once that know nothing of each other get done, in units of one alone: to measure two ranks by."""
    options = block(177, 60)
    alone = Run(options).seconds
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        pair = [run.seconds for run in pool.map(Run, [options, options])]
    return 2 * alone / max(pair)


def level_share_rows():
    """Shares of the wedge on three levels with the history and frames of a usual run."""
    runs = [Run(case("wedge_3level")) for _ in range(3)]
    for name, goal in (("Contact", 10), ("Coupling and Transfer", 8), ("Sort", 3), ("Output", 5)):
        events = name.split(" and ")
        row(f"three levels: {name}", Spread(sum(map(run.percent, events)) for run in runs), "%", goal)


def level_cost_rows():
    """Time a point and step on levels over that on one level of about as many points; one rank.

    For five levels its inverse: the share of what a uniform grid's ratio of point-steps promises that is gained.
    """
    pairs = {"wedge_3level": case("wedge_3level", max_steps=120, frames=0), "one": block(105, 120),
             "multiscale_5level": case("multiscale_5level", max_steps=8, frames=0), "same": block(190, 40)}
    _, runs = alternate(pairs, 3)
    cost = [1e9 * run.seconds / run.point_steps() / one.nanoseconds
            for run, one in zip(runs["wedge_3level"], runs["one"])]
    row("three levels: time of a point and step", Spread(cost), "times one level's", 1.2)
    gained = Spread(100 * one.nanoseconds / run.nanoseconds for run, one in zip(runs["multiscale_5level"], runs["same"]))
    row("five levels: share of the ideal gain", gained, "%", 60, 60 / gained.median)


def level_wall_rows():
    """Two ranks: the wedge on three levels; the five-level case, extrapolated from the start of its run."""
    def seconds(name, ranks, steps):
        run = Run(case(name, max_steps=steps, frames=0), ranks)
        return run.seconds / run.summary["steps"]

    row("three levels, wedge to 450 nm, 2 ranks", Run(case("wedge_3level"), 2).seconds, "s", 8)
    for name, steps in (("wedge_3level", 100), ("multiscale_5level", 15)):
        times = [[seconds(name, ranks, steps) for ranks in (1, 2)] for _ in range(3)]
        row(f"{name}, 2 ranks", Spread(one / two for one, two in times), "speed-up")
    whole = FIVE_LEVEL_STEPS * FIVE_LEVEL_GROWTH
    row("five levels, 2 ranks, extrapolated", Spread(whole * two for _, two in times), "s", 240)


def busy_row():
    """Two ranks while another program spins on one of the cores, over one rank that has a core of its own."""
    options, ratios = case("wedge_3level", max_steps=100, frames=0), []
    for _ in range(3):
        alone = Run(options).seconds
        other = subprocess.Popen(["sh", "-c", "while :; do :; done"])
        try:
            ratios.append(Run(options, 2).seconds / alone)
        finally:
            other.kill()
            other.wait()
    row("wedge_3level, 2 ranks and another program", Spread(ratios), "times one rank's", 1.3)


def level_balance_rows():
    """Largest over mean points of a rank and level, eight ranks, and what the balance costs."""
    for steps, goal in ((2, 1.05), (60, 1.15)):
        run = Run(case("multiscale_5level", max_steps=steps, frames=0), 8)
        row(f"five levels, 8 ranks, after {steps} steps", run.imbalance(), "largest/mean", goal)
    row("five levels, 8 ranks: share of Balance", run.percent("Balance"), "%", 2)


def main():
    Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    print(f"{'':40s} {'median (least .. greatest)':28s} {'unit':18s} {'goal':8s} ratio")
    runs = sweep_rows()
    share_rows(runs)
    size_rows()
    metal_rows()
    parallel_rows()
    empty_step_rows()
    level_share_rows()
    level_cost_rows()
    level_wall_rows()
    busy_row()
    level_balance_rows()


if __name__ == "__main__":
    main()
