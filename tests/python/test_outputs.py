"""Checks curves as instruments write them, and the page about tests: read back, escaped, valid, without a network."""
import html.parser
import io
import locale
import os
import re
import subprocess
import sys

import numpy as np
import pytest

import harness
from made_curves import CONE_OPTIONS, GOOD, curve, main, metal, refusal, text_of, write_run
from mlgimp import export, load_depth
from mlgimp.errors import Error

pytestmark = pytest.mark.fast


# ---- curves as instruments write them ----

@pytest.mark.parametrize("kind", export.FORMATS)
def test_read_back_without_a_change(tmp_path, kind, expect):
    """By the reader of measured files: depth, load and time to the digits that are written."""
    depth, load = metal()
    made = curve(depth, load, time=0.1 * np.arange(len(depth)))
    export.write(tmp_path / "m.txt", made, kind)
    read = load_depth.read_measured(tmp_path / "m.txt", "Depth:nm", "Load:uN", "Time:s")
    for name in ("depth", "load", "time"):
        expect(name, float(np.max(np.abs(getattr(read, name) - getattr(made, name))) / np.max(np.abs(getattr(made, name)))), at_most=1e-9)


def test_as_other_programs_read_it(tmp_path):
    """Readers of TriboScan's texts want a date, an empty line, the number of points, the columns' names with the depth in nm first, and
    then numbers alone, in ISO 8859-1."""
    depth, load = metal()
    export.write(tmp_path / "m.txt", curve(depth, load))
    content = (tmp_path / "m.txt").read_bytes().decode("iso-8859-1")
    date, empty, points, heads, *rows = content.splitlines()
    assert re.match(r"\d\d\.\d\d\.\d{4} ", date) and empty == "" and points == f"Number of Points = {len(depth)}"
    assert heads.split("\t") == ["Depth (nm)", "Load (\N{MICRO SIGN}N)", "Time (s)"]
    table = np.loadtxt(io.StringIO("\n".join(rows)))
    assert np.allclose(table[:, 0], 1e3 * depth) and np.allclose(table[:, 1], 1e3 * load) and np.all(np.diff(table[:, 2]) > 0)


def test_noise(expect):
    made = curve(*metal())
    one, same, other = (export.with_noise(made, (0.5, 20), seed) for seed in (1, 1, 2))
    assert np.array_equal(one.load, same.load) and not np.array_equal(one.load, other.load)
    expect("noise of the depth, of 800 rows to 3 %", float(np.std(one.depth - made.depth)), near=5e-4, tolerance=5e-5)
    expect("noise of the load", float(np.std(one.load - made.load)), near=0.02, tolerance=2e-3)
    for noise in ((-1, 0), (1,), "a,b", (np.nan, 1)):
        with pytest.raises(Error, match="NM,UN, two numbers >= 0"):
            export.with_noise(made, noise)


def test_a_run_is_analysed_the_same_from_its_export(tmp_path, capsys):
    folder = write_run(tmp_path / "run", CONE_OPTIONS)
    main([str(folder), "--export", "hysitron"])
    lines = dict(re.findall(r"^  (hardness|specimen's modulus) +(\S+)", capsys.readouterr().out, re.M))
    main([str(folder / "run.txt"), "--depth", "Depth:nm", "--load", "Load:uN", "--time", "Time:s", "--tip", "cone", "--half-angle", "70.3", "--poisson", "0.3"])
    assert dict(re.findall(r"^  (hardness|specimen's modulus) +(\S+)", capsys.readouterr().out, re.M)) == lines and len(lines) == 2


def test_nothing_is_written_over(tmp_path):
    (tmp_path / "m.txt").write_text(GOOD)
    assert "would write over" in refusal(tmp_path / "m.txt", "--tip", "vickers", "--export", "text")
    assert (tmp_path / "m.txt").read_text() == GOOD and "--export-noise: needs --export" in refusal(tmp_path / "m.txt", "--export-noise", "1,1")


# ---- the page ----

class Checker(html.parser.HTMLParser):
    """Keeps what is open; closes must be of the last one."""
    VOID = {"meta", "img", "br", "input"}

    def __init__(self, text):
        super().__init__()
        self.open, self.seen, self.words = [], [], []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        self.seen.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, tag

    def handle_data(self, data):
        self.words.append(data)


HOSTILE = "<script>alert('x')</script> & \"q\" \N{GREEK SMALL LETTER MU} %s {}"


def test_page_of_a_run(tmp_path):
    """Case, pictures, figures with uncertainties, options; whole, small, and nothing from a network."""
    folder = write_run(tmp_path / "run", CONE_OPTIONS | {"-m_youngs_modulus": "7e10", "-m_model": HOSTILE})
    main([str(folder), "--report", "--uncertainty", "200"])
    text = (folder / "indentation.html").read_text(encoding="utf-8")
    checker = Checker(text)
    words = " ".join(checker.words)
    assert text.startswith("<!DOCTYPE html>\n<html lang=\"en\">") and len(text) < 2e6
    assert [tag for tag, _ in checker.seen].count("img") == 1 and "script" not in [tag for tag, _ in checker.seen]
    assert not re.search(r"""(src|href)="(?!data:)|url\(|@import|<link""", text)
    for needed in ("hardness", "half angle", "youngs modulus", "Standard uncertainties by source", "95 % of the draws", "scripts/indentation.py", "-geometry", "<script>alert"):
        assert needed in words, needed


def test_hostile_names(tmp_path, monkeypatch):
    """A file's name and its text are shown as they are, and write no other file."""
    name = "a<b>&\"c'%s{}\N{LATIN SMALL LETTER U WITH DIAERESIS}.csv"
    (tmp_path / name).write_text(text_of(*metal()) + "<script>end of test 1</script>\n")
    main([str(tmp_path / name), "--tip", "vickers", "--report", "--export", "text"])
    checker = Checker((tmp_path / "indentation.html").read_text(encoding="utf-8"))
    assert "script" not in [tag for tag, _ in checker.seen] and any(name in word for word in checker.words)
    assert len(list(tmp_path.glob("*.txt"))) == 1 and "<" not in next(tmp_path.glob("*.txt")).name


def test_a_test_without_figures(tmp_path):
    (tmp_path / "good.csv").write_text(GOOD)
    (tmp_path / "bad.csv").write_text(text_of(*(values[:400] for values in metal())))
    with pytest.raises(SystemExit):
        main([str(tmp_path / "good.csv"), str(tmp_path / "bad.csv"), "--tip", "vickers", "--report", "--uncertainty", "100"])
    words = " ".join(Checker((tmp_path / "indentation.html").read_text()).words)
    assert "no figures: there is no unloading" in words and "hardness" in words


def test_in_a_locale_with_decimal_commas(tmp_path):
    """Numbers keep their points, and the files are the same."""
    known = [name for name in ("de_DE.UTF-8", "de_DE.utf8", "de_DE") if can_set(name)]
    (tmp_path / "m.csv").write_text(GOOD)
    words = [sys.executable, str(harness.ROOT / "scripts" / "indentation.py"), "m.csv", "--tip", "vickers", "--report", "--export", "hysitron"]
    for name in ["C", *known]:
        subprocess.run(words, cwd=tmp_path, check=True, capture_output=True, env={**os.environ, "LC_ALL": name, "PYTHONUTF8": "0"})
        assert not re.search(r">\d+,\d+<", (tmp_path / "indentation.html").read_text(encoding="utf-8"))
        assert "," not in "".join((tmp_path / "m.txt").read_text(encoding="latin-1").splitlines(True)[4:])


def can_set(name):
    """Whether there is a locale of this name."""
    before = locale.setlocale(locale.LC_ALL)
    try:
        locale.setlocale(locale.LC_ALL, name)
        return True
    except locale.Error:
        return False
    finally:
        locale.setlocale(locale.LC_ALL, before)
