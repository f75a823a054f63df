"""Checks that the documents are current: docs/options.md and docs/cheat_sheet.md against -help, and the files, functions and links that documents name."""

import re
import subprocess
import sys
import unittest

import pytest

import options_doc
from harness import ROOT
from options_doc import Option

pytestmark = pytest.mark.fast

DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
PATH = re.compile(r"(?:src|include|tests|scripts|python|examples|options|docs)/[\w./*]+")
NAME = re.compile(r"(?:([A-Z]\w*)::)?([A-Z]\w*[a-z]\w*)(?:\(.*)?")  # a type or a function, with or without its class
LINK = re.compile(r"\[[^]]+\]\(([\w./]+\.\w+)\)")
PLACEHOLDER = re.compile(r"NAME|CASE|WORD|FILE|Your")


def quoted(text):
    """What stands between backticks, outside of blocks."""
    return re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL))


def missing_paths(text):
    """Files that are named and not there; * stands for any name."""
    paths = {path.rstrip(".") for part in quoted(text) for path in PATH.findall(part) if not PLACEHOLDER.search(path)}
    return sorted(path for path in paths if not any(ROOT.glob(path)))


def missing_names(text, sources):
    """Types and functions that are named and not in the sources: a member must be in a file that defines its class."""
    missing = []
    for part in quoted(text):
        found = NAME.fullmatch(part)
        if found and not PLACEHOLDER.search(part):
            owner, name = found.groups()
            if not any(re.search(rf"\b{name}\b", source) and (not owner or re.search(rf"\b(?:class|struct) {owner}\b", source))
                       for source in sources):
                missing.append(part)
    return missing


def source_texts():
    return [path.read_text() for folder in ("src", "include", "tests", "scripts", "python") for path in sorted((ROOT / folder).rglob("*"))
            if path.suffix in (".cpp", ".hpp", ".py")]


class Tables(unittest.TestCase):
    LINES = ("Options for all PETSc programs:\n -help: prints\n----\nTime (s: second):\n"
             "  -cfl <now 0.4 : formerly 0.4>: fraction of h/(c + |v|) [%] (None)\n"
             "  -monitor <now false : formerly false>: a line (default: on a terminal) (None)\n"
             "  -restart <now  : formerly >: a file (None)\n")

    def test_help_is_read(self):
        self.assertEqual(options_doc.groups(self.LINES), {"Time": [
            Option("-cfl", "fraction of h/(c + |v|)", "%", "0.4"), Option("-monitor", "a line", "", "on a terminal"),
            Option("-restart", "a file", "", "none")]})

    def test_only_the_first_table_of_a_group_is_replaced(self):
        page = "# Options\n\n## Time\n\nBefore.\n\n| old |\n| --- |\n\nAfter.\n\n| kept |\n\n## Notes\n\n| kept |\n"
        wanted = page.replace("| old |\n| --- |", "\n".join(options_doc.HEADER) + "\n| `-cfl` | h/(c + \\|v\\|) |  | 0.4 |")
        groups = {"Time": [Option("-cfl", "h/(c + |v|)", "", "0.4")]}
        self.assertEqual(options_doc.rewrite(page, groups), wanted)
        self.assertEqual(options_doc.rewrite(wanted, groups), wanted)
        self.assertIn(":7 has", options_doc.first_difference(options_doc.PAGE, page, wanted))
        for lacking in ("# Options\n", "## Time\n\n## Notes\n\n| kept |\n"):
            with self.assertRaises(ValueError):
                options_doc.rewrite(lacking, groups)

    def test_options_in_few_words(self):
        for option, words in ((Option("-cfl", "fraction of h/(c + |v|); small", "%", "0.4"), "fraction of h/(c + |v|) [%], **0.4**"),
                              (Option("-side", "kind; x comes first: free, fixed", "", "free"), "kind: **free**, fixed"),
                              (Option("-steps", "last step; 0 = no limit", "", "0"), "last step, **0** = no limit"),
                              (Option("-restart", "a file", "", "none"), "a file")):
            self.assertEqual(option.in_few_words(), words)
        page = options_doc.sheet({"Time": [Option("-cfl", "h/(c + |v|)", "", "0.4")]})
        self.assertTrue(page.endswith("\n## Time\n\n| option | in few words |\n| --- | --- |\n| `-cfl` | h/(c + \\|v\\|), **0.4** |\n"))

    def test_the_pages_are_current(self):
        done = subprocess.run([sys.executable, str(ROOT / "scripts" / "options_doc.py"), "--check"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class Names(unittest.TestCase):
    def test_what_is_missing_is_found(self):
        text = "`src/physics/*.cpp`, `src/none.cpp`, `Level::Create`, `Level::Vanish(x)`, `tests/unit/NAME.cpp`\n```\n`src/block.cpp`\n```\n"
        self.assertEqual(missing_paths(text), ["src/none.cpp"])
        self.assertEqual(missing_names(text, ["class Level { Create(); };", "Vanish"]), ["Level::Vanish(x)"])

    def test_files_and_functions_of_documents_exist(self):
        sources = source_texts()
        for document in DOCUMENTS:
            text = document.read_text()
            with self.subTest(document=document.name):
                self.assertEqual(missing_paths(text), [])
                self.assertEqual(missing_names(text, sources), [])

    def test_links_lead_somewhere(self):
        for document in DOCUMENTS:
            targets = [name for name in LINK.findall(document.read_text()) if not name.startswith("results/")]  # which `make docs` writes
            self.assertEqual([name for name in targets if not (document.parent / name).exists()], [], document.name)
