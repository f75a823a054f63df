#!/usr/bin/env python3
"""Efficiency on many ranks, predicted from what PETSc counts on few.

usage: scripts/scaling.py [RANKS ...]        default 2 4 8 16; more ranks than cores are slow, 64 of them take minutes

Runs one level (500 x 500 cells, a million points) and the five levels of options/multiscale_5level.opts for a few steps,
and prints messages, kilobytes and collective calls of a rank and level step, and the imbalance of points. The model:

    T(rank, level step) = imbalance * points * POINT_SECONDS + messages * LATENCY + bytes / BANDWIDTH
                          + collectives * LATENCY * log2(ranks)  +  on the finest level CONTACT_SECONDS

Levels step one after the other, each on the ranks that it uses; with f times fewer points a rank, bytes fall as sqrt(f), and
imbalance - 1, which is that of whole layers of nodes, grows as sqrt(f).
Efficiency is points * POINT_SECONDS / T, summed over levels. Contact is what its root does alone. The prediction is from
the largest number of ranks counted; with fewer than 16 a rank has too few neighbours.
"""
import argparse
import sys
from math import log2, sqrt
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command, whole_number_from
from bench import Run, block, case

LATENCY, BANDWIDTH = 2e-6, 10e9  # s, bytes/s
POINT_SECONDS = 60e-9            # one core, default scheme, from `make bench`
CONTACT_SECONDS = 0.26e-3        # in a step of the finest of five levels, mean of the whole run on one rank
STEPS = 4
TARGETS = (64, 1024, 16384)


def counts(run):
    """Per level, of a level step: messages and bytes of a rank in use and collectives of any rank, beside the summary's."""
    rows = []
    for l, level in enumerate(run.summary["levels"]):
        ranks = {"messages": level["ranks"], "bytes": level["ranks"], "reductions": run.log.ranks}
        totals = {figure: run.log.total(figure, stage=f"level {l}") / level["steps"] / n for figure, n in ranks.items()}
        rows.append({**level, **totals})
    return rows


def seconds(level, ranks, points):
    """A level step on `ranks` ranks with `points` points each."""
    edge = sqrt(points * level["ranks"] / level["points"])  # of a block, over that in the run counted
    wire = level["messages"] * LATENCY + level["bytes"] * edge / BANDWIDTH
    return (1 + (level["imbalance"] - 1) / edge) * points * POINT_SECONDS + wire + level["reductions"] * LATENCY * log2(max(ranks, 2))


def efficiency(levels, ranks, used, points):
    """Useful share of the time of `ranks` ranks, of which each level uses used[l] with points[l] points each."""
    contact = CONTACT_SECONDS * 2 ** (len(levels) - 1) if len(levels) > 1 else 0
    spent = contact + sum(2**l * seconds(level, used[l], points[l]) for l, level in enumerate(levels))
    useful = contact / ranks + sum(2**l * POINT_SECONDS * points[l] * used[l] / ranks for l in range(len(levels)))
    return useful / spent


def fixed_points(levels, ranks, points):
    """All levels on all ranks, with the same points a rank on each; contact as large as in the run counted."""
    return efficiency(levels, ranks, [ranks] * len(levels), [points] * len(levels))


def fixed_problem(levels, ranks, least_points):
    """The problem counted on more ranks; a level uses no more than leave each `least_points` points."""
    used = [min(ranks, max(1, int(level["points"] / least_points))) for level in levels]
    return efficiency(levels, ranks, used, [level["points"] / n for level, n in zip(levels, used)])


def count_row(name, levels, ranks):
    for l, level in enumerate(levels):
        print(f"{name if l == 0 else '':12s} {ranks if l == 0 else '':>5} {l:5d} {level['ranks']:5d} {level['points']:8.0f} "
              f"{level['imbalance']:9.3f} {level['messages']:8.1f} {level['bytes'] / 1e3:8.1f} {level['reductions']:11.2f}", flush=True)


def number_of_ranks(word):
    try:
        return whole_number_from(1)(word)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{word}: must be a whole number >= 1") from None


@command
def main(words):
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ranks", nargs="*", type=number_of_ranks, default=[2, 4, 8, 16], metavar="RANKS")
    numbers = parser.parse_args(words).ranks
    cases = {"one level": block(500, STEPS, points_per_rank=1),
             "five levels": case("multiscale_5level", max_steps=STEPS, frames=0)}
    print("case         ranks level  used   points imbalance messages       kB collectives")
    last = {}
    for ranks in numbers:
        for name, options in cases.items():
            last[name] = counts(Run(options, ranks))
            count_row(name, last[name], ranks)
    print("\npredicted efficiency in percent     " + "".join(f"{ranks:>8d}" for ranks in TARGETS))
    for name, levels in last.items():
        for points in (1000, 4000, 16000):
            print(f"{name}, {points} points a rank".ljust(36) +
                  "".join(f"{100 * fixed_points(levels, n, points):8.1f}" for n in TARGETS))
        least = 1 if name == "one level" else 1000
        print(f"{name}, fixed problem".ljust(36) + "".join(f"{100 * fixed_problem(levels, n, least):8.1f}" for n in TARGETS))


if __name__ == "__main__":
    main(sys.argv[1:])
