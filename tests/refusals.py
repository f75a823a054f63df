"""Tables of options that the program refuses: how each row is tried, and what is expected of every refusal."""
import concurrent.futures
import pathlib
import shutil
import subprocess
import tempfile
import time
from collections import namedtuple

import harness

LONGEST = 15  # seconds that a refusal may take on a busy machine

# A row is (name, options that differ from those of the base, words of the line that is expected). Each is tried on one rank, and each
# `every`-th on `ranks` as well; an option that is None is taken out, and one that is "" stands without a value.
Table = namedtuple("Table", "base rows ranks every", defaults=(3, 3))


def without(*names):
    return {name: None for name in names}


def words_of(options):
    """{'name': 'value'} -> ['-name', 'value']."""
    given = {name: value for name, value in options.items() if value is not None}
    return [word for name, value in given.items() for word in harness.to_arguments({name: None if value == "" else value})]


def contents(folder):
    return sorted((str(path.relative_to(folder)), path.stat().st_size) for path in folder.rglob("*"))


def problem_of(words, folder, ranks, expected):
    """What is wrong with the way the program refuses these words in a folder; empty where nothing is."""
    before, begin = contents(folder), time.time()
    try:
        done = subprocess.run(harness.command(words, ranks), capture_output=True, text=True, env=harness.environment(ranks), cwd=folder,
                              timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return f"still running after {LONGEST} s"
    lines = harness.lines_of(done.stderr)
    if done.returncode <= 0:
        return f"exit status {done.returncode}: {done.stderr.strip()[-300:]}"
    if len(lines) != 1 or not lines[0].startswith("mlgimp: error: "):
        return f"{len(lines)} lines on standard error: " + " | ".join(lines)[:400]
    absent = [word for word in expected if word not in lines[0]]
    if absent:
        return f"no {absent} in: {lines[0]}"
    if "step" in done.stdout or time.time() - begin > LONGEST:
        return "refused late: " + done.stdout[-200:]
    left = sorted(set(contents(folder)) ^ set(before))
    return f"files changed: {left}" if left else ""


def inputs(table):
    """(name, words, expected, text of the options file that the words name last, or None) of all rows.

    In place of options a row may have a list of words that follow those of the base, and behind what is expected the file's text.
    """
    for name, changes, expected, *text in table.rows:
        plain = {"output_dir": "out", **table.base}
        words = words_of({**plain, **changes}) if isinstance(changes, dict) else words_of(plain) + changes
        yield name, words, expected, text[0] if text else None


def problem_alone(row, ranks, files, place):
    """problem_of() a row in a folder of its own at some place, with copies of those files."""
    _, words, expected, text = row
    own = pathlib.Path(tempfile.mkdtemp(dir=place))
    if files:
        shutil.copytree(files, own, dirs_exist_ok=True)
    if text is not None:
        (own / words[-1]).write_bytes(text)
    problem = problem_of(words, own, ranks, expected)
    shutil.rmtree(own)
    return problem


def expect_refused(expect, table, files=None, on=None):
    """Every row is refused: on its numbers of ranks, or on so many. `files`: a folder with what the rows name."""
    rows, place = list(inputs(table)), harness.scratch()
    assert len({row[0] for row in rows}) == len(rows), "two rows have the same name"
    tried = [(row, on) for row in rows] if on else [(row, 1) for row in rows] + [(row, table.ranks) for row in rows[::table.every]]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        problems = pool.map(lambda each: problem_alone(*each, files, place), tried)
        for (row, ranks), problem in zip(tried, problems):
            expect.that(f"{row[0]}, on {ranks} {'rank' if ranks == 1 else 'ranks'}", not problem, problem)
