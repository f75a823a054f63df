"""The files that `make install` leaves: program, scripts, examples and manual page work from there; nothing is built anew."""
import os
import subprocess

import harness
import options_doc


def test_install(tmp_path):
    prefix, program = tmp_path / "a prefix", harness.BIN.relative_to(harness.ROOT) / "mlgimp"
    environment = {**harness.environment(1), "MAKEFLAGS": ""}
    subprocess.run(["make", "-s", "-o", str(program), f"BIN={program.parent}", f"PREFIX={prefix}", "install"], cwd=harness.ROOT,
                   env=environment, check=True, timeout=60)
    share = prefix / "share" / "mlgimp"
    assert not any(folder.endswith("__pycache__") for folder, _, _ in os.walk(share))
    assert (share / "scripts" / "plot.py").is_file() and os.path.samefile(share / "bin" / "mlgimp", prefix / "bin" / "mlgimp")
    words = ["-options_file", share / "options" / "wedge_500nm.opts", "-max_steps", "2", "-frames", "1", "-monitor", "false"]
    subprocess.run([prefix / "bin" / "mlgimp", *words], cwd=tmp_path, env=environment, check=True, timeout=60)
    assert (tmp_path / "output" / "wedge_500nm" / "summary.json").is_file()
    check_page((prefix / "share" / "man" / "man1" / "mlgimp.1").read_text())


def check_page(page):
    """Every option of -help has an entry."""
    run = subprocess.run([harness.PROGRAM, "-help"], capture_output=True, text=True, env=harness.environment(1), check=True)
    groups = options_doc.groups(run.stdout)
    assert page.startswith(".TH MLGIMP 1") and len(groups) >= 8
    for heading, options in groups.items():
        assert f".SH {heading.upper()}\n" in page
        for option in options:
            assert f".B {option.name}\n".replace("-", r"\-") in page, option.name
