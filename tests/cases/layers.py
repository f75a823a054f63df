"""The sources keep to their layers, are short, say what they are, and read every option that an example uses."""
import re
import subprocess

import pytest

import harness

pytestmark = pytest.mark.fast

LAYERS = ("base", "pointwise", "grid", "points", "contact", "level", "hierarchy", "program")  # a file includes only its own layer and those before it
LONGEST = 400  # lines


def sources(*folders):
    """Files of C++ and Python in folders of the repository."""
    return [path for folder in folders for path in sorted((harness.ROOT / folder).rglob("*"))
            if path.suffix in (".hpp", ".cpp", ".py")]


def short(path):
    return str(path.relative_to(harness.ROOT))


def test_layers(expect):
    upwards, layers_seen = [], set()
    for path in sources("include", "src"):
        own = path.relative_to(harness.ROOT).parts[1]
        layers_seen.add(own)
        for header in re.findall(r'^\s*#\s*include\s+"([^"]+)"', path.read_text(), re.M):
            layer = header.split("/")[0]
            known = own in LAYERS and layer in LAYERS and (harness.ROOT / "include" / header).exists()
            if not known or LAYERS.index(layer) > LAYERS.index(own):
                upwards.append(f"{short(path)} includes {header}")
    expect.that("includes go only downwards", not upwards, "; ".join(upwards))
    expect.that("every layer has files, and every folder is a layer", layers_seen == set(LAYERS), ", ".join(sorted(layers_seen)))
    misplaced = [short(path) for path in sources("include") if path.suffix != ".hpp"]
    misplaced += [short(path) for path in sources("src") if path.suffix != ".cpp"]
    expect.that("headers in include/, sources in src/", not misplaced, ", ".join(misplaced))


def test_low_layers_know_no_mesh(expect):
    """Pointwise physics sees neither PETSc nor MPI."""
    wrong = [short(path) for path in sources("include/pointwise", "src/pointwise")
             if re.search(r"\b(Petsc\w*|MPI_\w+|DM[A-Z]\w*|Vec[A-Z]\w+)\b|petsc|mpi\.h", path.read_text())]
    expect.that("the pointwise layer knows no PETSc and no MPI", not wrong, ", ".join(wrong))


def test_length(expect):
    long = [f"{short(path)} {lines}" for path in sources("include", "src", "python", "docs")
            if (lines := len(path.read_text().splitlines())) > LONGEST]
    expect.that(f"no source has over {LONGEST} lines", not long, ", ".join(long))


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
