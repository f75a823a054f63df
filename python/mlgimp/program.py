"""Runs the program mlgimp: finds it, shows how far it is, and turns its one line of an error into an exception."""

import inspect
import os
import re
import selectors
import shutil
import signal
import subprocess
import sys
import warnings
from collections.abc import Mapping
from pathlib import Path

from . import checks, hints
from . import options as text
from .errors import Error, Interrupted, RunError
from .folder import read

PROJECT = Path(__file__).resolve().parents[2]  # the folder that the package lies in where it is not installed
# For Open MPI in containers and on machines with few cores; what the user has set counts more.
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_mpi_yield_when_idle": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe"}  # Open MPI 4, 5
STOPPED = re.compile(r"ended by SIGTERM at step (\d+); go on with -restart (.*)")  # of the program's line
ALONE = {"OMPI_MCA_ess_singleton_isolated": "1"}  # one process needs no daemon of Open MPI, whose folder another run may take away
BAR, LEAST_BAR = 30, 5  # characters that a bar has, and less than which it is left out
MONITOR = re.compile(r"depth (\S+) m  load (\S+) N .* (\d+) %  (\d+) s left")  # of the program's progress line


def run(options, ranks=1, *, progress=None, **more):
    """Runs a case and returns its Results.

    options: path of an options file, or a dict {"cell_size": 5e-7, "domain_upper": (24e-6, 24e-6), "overwrite": True, ...} of the
    program's options without their dashes (SI units), where "options_file" may name a file; `more` are further options, which
    count more. The results go to `output_dir`, by default output/ and the options file's name in the present folder.
    ranks: processes, started by mpiexec where they are several. progress: whether to show a bar; by default on a terminal and in
    a notebook.

    Raises RunError with the program's line where the run does not reach its end; warnings of the program become warnings here,
    as soon as it gives them. An interrupt, of the keyboard or of a notebook, lets the program write a checkpoint and end, and becomes an
    Interrupted, a KeyboardInterrupt whose text says how to go on; a second one ends the program at once.
    """
    if not isinstance(options, (str, os.PathLike, Mapping)):
        raise checks.refusal("options", options, "the path of an options file, or a dict of options")
    hints.check_names(more, hints.arguments(run))
    values = {**text.named(options if isinstance(options, Mapping) else {"options_file": options}), **text.named(more)}
    for name in {"options_file", "output_dir"} & values.keys():
        checks.path(name, values[name])
    try:
        execute(values, ranks, is_watched() if progress is None else progress, warn, may_stop=True)
    except RunError as problem:
        raise hints.of_unread(problem, hints.arguments(run), option_names()) if is_about(problem, more) else problem from None
    return read(output_folder(values))


def is_about(problem, names):
    """Whether the program has ended because nothing reads one of these options."""
    return any(f"-{name}: unknown or unused option" in str(problem) for name in names)


def output_folder(options):
    """Returns the folder to which a run with these options writes: the one they name, or their file names, or that of its name."""
    file = options.get("options_file")
    given = {**(text.read_options(file) if file else {}), **options}.get("output_dir")
    return Path(given or Path("output") / (Path(file).stem if file else "run"))


def execute(options, ranks=1, progress=False, tell=lambda line: None, may_stop=False):
    """Runs the program with a dict of options to its end, see run; `tell` gets the line of each warning when it comes. may_stop: an
    interrupt reaches only this process, which lets the program write a checkpoint."""
    ranks = checks.whole("ranks", ranks, 1)
    file, others = options.get("options_file"), {name: value for name, value in options.items() if name != "options_file"}
    words = ([] if file is None else ["-options_file", str(file)]) + text.to_words({**others, "monitor": progress})
    start = ["mpiexec", "-n", str(ranks)] if ranks > 1 else []
    lines = []

    def keep(line):
        lines.append(line)
        if line.startswith("mlgimp: warning:"):
            tell(line)

    try:
        process = subprocess.Popen([*start, find_program(), *words], bufsize=0, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, start_new_session=may_stop,
                                   env={**ENVIRONMENT, **(ALONE if ranks == 1 else {}), **os.environ})
    except OSError as problem:
        raise Error(f"{problem.filename}: cannot be started ({problem.strerror})") from None
    try:
        status = watch(process, progress, keep)
    except KeyboardInterrupt:
        raise Interrupted(how_to_go_on(lines, options)) from None
    if status != 0:
        raise RunError(line_of_failure(lines, status))


def how_to_go_on(lines, options):
    """Returns the text of an Interrupted, from the lines on standard error and the options of the run."""
    folder, found = str(output_folder(options)), list(filter(None, map(STOPPED.search, lines)))
    if not found:
        return f"stopped, without a checkpoint; mlgimp.read({folder!r}) has what had been written"
    step, checkpoint = found[0].groups()
    is_of_file = options.keys() <= {"options_file", "overwrite"}  # as that of mlgimp.indent, which writes it
    call = f"mlgimp.run({str(options['options_file'])!r}, restart={checkpoint!r})" if is_of_file else f"the same call with restart={checkpoint!r}"
    return f"stopped at step {step}: mlgimp.read({folder!r}) has what is done; {call} goes on"


def option_names():
    """Returns the names of all options that the program's -help lists, without dashes; NAME_ stands for a material, body or load."""
    listed = subprocess.run([find_program(), "-help"], capture_output=True, text=True, env={**ENVIRONMENT, **os.environ}, stdin=subprocess.DEVNULL)
    return re.findall(r"^  -(\w+):? <", listed.stdout, re.M)


def warn(line):
    """Warns in the name of the line outside of this package that has asked for the run."""
    folder = Path(__file__).parent
    callers = [Path(frame.filename).parent for frame in inspect.stack(context=0)]
    warnings.warn(line, stacklevel=1 + next((k for k, place in enumerate(callers) if place != folder), 0))


def find_program():
    """Returns the program's path: in the folder MLGIMP_BIN of the environment, else in bin/ of the project, else on PATH."""
    given = os.environ.get("MLGIMP_BIN")
    place = PROJECT / (given or "bin") / "mlgimp"
    found = str(place) if place.exists() else None if given else shutil.which("mlgimp")
    if not found:
        looked = f"at {place}" if given or (PROJECT / "makefile").exists() else "on PATH"
        raise Error(f"the program mlgimp is not {looked}: `make` builds it; MLGIMP_BIN may name the folder that holds it")
    return found


def line_of_failure(lines, status):
    """Returns the one line for a run that failed, from its lines on standard error and its exit status."""
    own = [line for line in lines if line.startswith("mlgimp: error:")]
    others = [line for line in lines if re.search(r"\w", line)]
    return (own or others or [f"mlgimp ended with exit status {status}"])[0]


def is_watched():
    """Whether somebody sees what is printed now: on a terminal or in a notebook."""
    return sys.stdout.isatty() or "ipykernel" in sys.modules


def watch(process, progress, tell):
    """Waits for a process, shows a bar where asked to, calls `tell` with each line of its standard error, and returns the exit
    status. An interrupt here ends the process by SIGTERM and goes on when it has ended, any other exception, also a second interrupt, at once."""
    with process:
        try:
            try:
                for line in read_lines(process.stdout, process.stderr, show_progress if progress else lambda piece: None):
                    tell(line)
            except KeyboardInterrupt:
                os.kill(one_rank(process.pid), signal.SIGTERM)
                for line in read_lines(process.stdout, process.stderr, lambda piece: None):
                    tell(line)
                process.wait()
                raise
        except BaseException:
            process.terminate()  # a second SIGTERM ends the program at once, and one that has ended gets none
            raise
        finally:
            if progress:
                print()
    return process.returncode


def one_rank(number):
    """Returns the number of a process that is a rank of the program: this one, or below mpiexec the first of its ranks; mpiexec itself would
    kill all ranks before they have written a checkpoint."""
    try:
        below = Path(f"/proc/{number}/task/{number}/children").read_text().split()
        return next((int(each) for each in below if Path(f"/proc/{each}/comm").read_text().strip() == "mlgimp"), number)
    except OSError:  # no such system, or a process that has just ended
        return number


def read_lines(output, errors, show):
    """Yields the lines of a stream of errors as they come, and calls `show` with each piece of the other; to the end of both."""
    rest = b""
    with selectors.DefaultSelector() as streams:
        for stream in (output, errors):
            streams.register(stream, selectors.EVENT_READ)
        while streams.get_map():
            for key, _ in streams.select():
                piece = key.fileobj.read(65536)
                if not piece:
                    streams.unregister(key.fileobj)
                elif key.fileobj is output:
                    show(piece.decode(errors="replace"))
                else:
                    *lines, rest = (rest + piece).split(b"\n")
                    yield from (line.decode(errors="replace") for line in lines)
    if rest:
        yield rest.decode(errors="replace")


def show_progress(piece):
    """Shows a bar for the last progress line in a piece of the program's output."""
    found = MONITOR.findall(piece)
    if found:
        depth, load, percent, left = found[-1]
        where = f"depth {1e6 * float(depth):.3g} um, load {1e3 * float(load):.3g} mN"
        show_bar(int(percent), 100, f"{percent} %, {where}, {left} s left")


def show_bar(done, count, words, end=""):
    """Prints a bar over the last one in the same line; bar and words are cut to what the terminal's line has room for. end: what follows."""
    room = shutil.get_terminal_size().columns - 1  # the last column takes some terminals to the next line
    bar = min(BAR, room - len(f"[] {words}"))
    full = BAR * done // count * bar // BAR
    line = f"[{'#' * full}{'.' * (bar - full)}] {words}" if bar >= LEAST_BAR else words
    print("\r" + f"{line}   "[:room], end=end, flush=True)
