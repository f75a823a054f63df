"""The sources keep to their layers, say what they are, and read every option that an example uses."""
import pathlib
import re
import subprocess

import pytest

import harness

pytestmark = pytest.mark.fast

# A file includes only its own layer and those before it; in a layer with rooms only its own room and those before it.
LAYERS = ("base", "physics", "grid", "points", "surface", "contact", "level", "hierarchy", "program")
ROOMS = {"physics": ("crystal", "", "tips"), "level": ("sweeps", ""), "hierarchy": ("partition", "coupling", "transfer", ""),
         "program": ("system", "options", "case", "slow_test", "advice", "input", "output", "checkpoint", "run")}
MOST_IN_ROOM = 12  # files
LONGEST = 400  # lines

# Words that a reader of plain English stumbles over, and beginnings of names that say less than an ordinary verb or noun would.
ODD_WORDS = re.compile(r"\b(told|tells|lacks?|felt|whom|nobody|somebody|rubbed)\b", re.I)
ODD_NAMES = re.compile(r"\b(k(Most|Least)\w*|Note[A-Z]\w*)")


def sources(*folders):
    """Files of C++ and Python in folders of the repository."""
    return [path for folder in folders for path in sorted((harness.ROOT / folder).rglob("*"))
            if path.suffix in (".hpp", ".cpp", ".py")]


def short(path):
    return str(path.relative_to(harness.ROOT))


def floor(path):
    """Of a file below include/ or src/: its place among the layers and rooms; None where there is no such room."""
    layer, *room = path.parts[:-1]
    rooms = ROOMS.get(layer, ("",))
    known = layer in LAYERS and len(room) <= 1 and (room or [""])[0] in rooms
    return (LAYERS.index(layer), rooms.index((room or [""])[0])) if known else None


def test_layers(expect):
    upwards, strangers, files = [], set(), {}
    for path in sources("include", "src"):
        inside = pathlib.Path(*path.relative_to(harness.ROOT).parts[1:])
        own = floor(inside)
        files.setdefault(path.parent, []).append(path)
        if own is None:
            strangers.add(short(path.parent))
            continue
        for header in re.findall(r'^\s*#\s*include\s+"([^"]+)"', path.read_text(), re.M):
            other = floor(pathlib.Path(header)) if (harness.ROOT / "include" / header).exists() else None
            if other is None or other > own:
                upwards.append(f"{short(path)} includes {header}")
    expect.that("includes go only downwards", not upwards, "; ".join(upwards))
    expect.that("every folder is a layer or a room", not strangers, ", ".join(sorted(strangers)))
    seen = {floor(pathlib.Path(*path.relative_to(harness.ROOT).parts[1:])) for group in files.values() for path in group}
    expect("layers and rooms without files", len({(k, r) for k, layer in enumerate(LAYERS) for r in range(len(ROOMS.get(layer, ("",))))} - seen), at_most=0)
    full = [f"{short(folder)} {len(group)}" for folder, group in files.items() if len(group) > MOST_IN_ROOM]
    expect.that(f"no room of more than {MOST_IN_ROOM} files", not full, ", ".join(full))
    misplaced = [short(path) for path in sources("include") if path.suffix != ".hpp"]
    misplaced += [short(path) for path in sources("src") if path.suffix != ".cpp"]
    expect.that("headers in include/, sources in src/", not misplaced, ", ".join(misplaced))


def test_low_layers_know_no_mesh(expect):
    """Physics of a point sees neither PETSc nor MPI."""
    wrong = [short(path) for path in sources("include/physics", "src/physics")
             if re.search(r"\b(Petsc\w*|MPI_\w+|DM[A-Z]\w*|Vec[A-Z]\w+)\b|petsc|mpi\.h", path.read_text())]
    expect.that("the layer of physics knows no PETSc and no MPI", not wrong, ", ".join(wrong))


def test_length(expect):
    """Of modules in Python; what bounds sources of C++ is in classes.py."""
    long = [f"{short(path)} {lines}" for path in sources("python", "docs", "scripts")
            if (lines := len(path.read_text().splitlines())) > LONGEST]
    expect.that(f"no module has over {LONGEST} lines", not long, ", ".join(long))


def test_first_line(expect):
    """A comment of some words: '// ...' or, after '#!', a docstring."""
    silent = []
    for path in sources("include", "src", "tests", "scripts", "python", "docs"):
        lines = [line for line in path.read_text().splitlines() if not line.startswith("#!")]
        start = r"// \w+(\W+\w+){2}" if path.suffix in (".hpp", ".cpp") else r'"""\w+(\W+\w+){2}'
        if not lines or not re.match(start, lines[0]):
            silent.append(short(path))
    expect.that("every file begins by saying what it is", not silent, ", ".join(silent))


def test_nothing_left_over(expect):
    words = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|HA" r"CK)\b")
    marked = [short(path) for path in sources("include", "src", "tests", "scripts", "python", "docs") if words.search(path.read_text())]
    expect.that("no notes of unfinished work", not marked, ", ".join(marked))


def test_plain_words(expect):
    """In sources and documents, but for what `make verify` writes, whose words are those of the tests."""
    made, odd = re.compile(r"<!-- \S+: written by make verify -->.*?<!-- end -->", re.S), []
    pages = [harness.ROOT / name for name in ("README.md", "CONTRIBUTING.md")] + sorted((harness.ROOT / "docs").rglob("*.md"))
    for path in sources("include", "src", "docs") + pages:
        text = made.sub(lambda part: "\n" * part[0].count("\n"), path.read_text())
        odd += [f"{short(path)}:{number} {found[0]}" for number, line in enumerate(text.split("\n"), 1)
                for words in (ODD_WORDS, ODD_NAMES) for found in words.finditer(line)]
    expect.that("plain words", not odd, ", ".join(odd))


def test_example_options(expect):
    """Every option of the files in options/ has its line in -help; NAME_ stands for a name given in the file."""
    help_text = subprocess.run(harness.command(["-help"], 1), capture_output=True, text=True, env=harness.ENVIRONMENT,
                               cwd=harness.ROOT).stdout
    known = set(re.findall(r"^\s+-(\w+)[ :]", help_text, re.M))
    expect("options in -help", len(known), at_least=60)
    files = sorted((harness.ROOT / "options").glob("*.opts"))
    expect("example files", len(files), at_least=2)
    for path in files:
        options = [line.split() for line in path.read_text().splitlines() if line.startswith("-")]
        names = {name for words in options if words[0] in ("-materials", "-bodies", "-loads") for name in words[1].split(",")}
        unknown = [option for option in (re.sub(r"^level_\d+_", "level_1_", words[0][1:]) for words in options)
                   if option not in known and not
                   any(option.startswith(name + "_") and "NAME" + option[len(name):] in known for name in names)]
        expect.that(f"{path.name}: options are in -help", options and not unknown, ", ".join(unknown))
