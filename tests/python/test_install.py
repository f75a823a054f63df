"""The files that `make install` leaves: program, scripts, examples and manual page work from there; nothing is built anew."""
import os
import re
import subprocess

import harness
import options_doc
import test_options_doc


def test_install(tmp_path):
    prefix, program = tmp_path / "a prefix", harness.BIN.relative_to(harness.ROOT) / "mlgimp"
    environment = {**harness.environment(1), "MAKEFLAGS": ""}
    subprocess.run(["make", "-s", "-o", str(program), f"BIN={program.parent}", f"PREFIX={prefix}", "install"], cwd=harness.ROOT,
                   env=environment, check=True, timeout=60)
    share = prefix / "share" / "mlgimp"
    assert not any(folder.endswith("__pycache__") for folder, _, _ in os.walk(share))
    assert (share / "scripts" / "plot.py").is_file() and (share / "python" / "mlgimp" / "viewer.js").is_file()
    assert os.path.samefile(share / "bin" / "mlgimp", prefix / "bin" / "mlgimp")
    words = ["-options_file", share / "options" / "wedge_500nm.opts", "-max_steps", "2", "-frames", "1", "-monitor", "false"]
    subprocess.run([prefix / "bin" / "mlgimp", *words], cwd=tmp_path, env=environment, check=True, timeout=60)
    assert (tmp_path / "output" / "wedge_500nm" / "summary.json").is_file()
    check_page((prefix / "share" / "man" / "man1" / "mlgimp.1").read_text())
    check_hints(prefix / "bin", tmp_path, environment)
    check_links(share)


def check_hints(folder, elsewhere, environment):
    """Files that the program names are there, from wherever and however it is called."""
    environment = {**environment, "PATH": f"{folder}:{environment['PATH']}"}
    for here, name in ((elsewhere, "mlgimp"), (elsewhere, folder / "mlgimp"), (folder.parent / "share" / "mlgimp", "mlgimp"),
                       (harness.ROOT, harness.PROGRAM.relative_to(harness.ROOT))):
        said = subprocess.run([name], cwd=here, env=environment, capture_output=True, text=True, timeout=60).stderr
        case, page = re.search(r"-options_file (.*)\n", said)[1], re.search(r"your own: +(.*)\n", said)[1]
        assert f" {name} -options_file " in said and (here / case).is_file() and (here / page).is_file(), said
        shown = subprocess.run([name, "-help"], cwd=here, env=environment, capture_output=True, text=True, timeout=60).stdout
        assert shown.startswith("mlgimp: ") and f"\n  {name} -options_file {os.path.dirname(case)}/NAME.opts" in shown[:1000]


def check_links(share):
    """What the documents link to is installed."""
    for page in (share / "README.md", share / "CONTRIBUTING.md", *(share / "docs").glob("*.md")):
        links = [name for name in test_options_doc.LINK.findall(page.read_text()) if not name.startswith("results/")]  # which `make docs` writes
        assert all((page.parent / link).exists() for link in links), (page, links)
    assert all((share / name).is_file() for name in ("LICENSE", "CHANGELOG.md", "CITATION.cff", "examples/first_indentation.ipynb"))


def check_page(page):
    """Every option of -help has an entry."""
    run = subprocess.run([harness.PROGRAM, "-help"], capture_output=True, text=True, env=harness.environment(1), check=True)
    groups = options_doc.groups(run.stdout)
    assert page.startswith(".TH MLGIMP 1") and len(groups) >= 8
    for heading, options in groups.items():
        assert f".SH {heading.upper()}\n" in page
        for option in options:
            assert f".B {option.name}\n".replace("-", r"\-") in page, option.name
