"""Checks messages in the C++ sources: each literal with {} is followed by as many values."""

import re

import pytest

from harness import ROOT

pytestmark = pytest.mark.fast

LITERAL = r'(?:"(?:\\.|[^"\\])*"\s*)+'
TOKEN = re.compile(r"//[^\n]*|#[^\n]*|" + LITERAL + r"|'(?:\\.|[^'\\])'|.", re.DOTALL)


def calls(text):
    """The arguments of all calls, also of those in arguments, each as its text."""
    open_calls, found = [[""]], []
    for token in TOKEN.findall(text):
        if token[:2] == "//" or token[0] == "#":
            continue
        if token in "([{":
            open_calls.append([""])
        elif token in ")]}":
            arguments = open_calls.pop()
            found.append([argument.strip() for argument in arguments])
            open_calls[-1][-1] += "()"
        elif token == ",":
            open_calls[-1].append("")
        else:
            open_calls[-1][-1] += token
    return found


def mistakes(text):
    """Literals with {} that have too few or too many values behind them."""
    found = []
    for arguments in calls(text):
        for place, argument in enumerate(arguments):
            wanted, values = re.sub(r'"\s*"', "", argument).count("{}"), len(arguments) - place - 1
            if wanted and not (re.fullmatch(LITERAL, argument) and wanted == values):
                found.append(argument)
    return found


def test_finds_mistakes():
    assert mistakes('Format("{} and {}", 1)') and mistakes('Refuse(name, "{}", f(1), 2)') and mistakes('Format(a ? "{}" : "", 1)')
    assert not mistakes('Format("{}, {" "}", Format("{}", a[1, 2]), g(3, 4));  // "{}"')


def test_values_of_messages():
    sources = [path for folder in ("src", "include") for path in (ROOT / folder).rglob("*.?pp")]
    texts = {path: path.read_text() for path in sources if path.name != "text.cpp"}  # which looks for {}
    assert sum(text.count("{}") for text in texts.values()) > 100
    assert not {str(path): found for path, text in texts.items() if (found := mistakes(text))}
