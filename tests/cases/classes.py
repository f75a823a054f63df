"""Classes stay small: at most 15 data members and 20 public functions, one source file, and functions that fit on a screen."""
import re

import pytest

import harness

pytestmark = pytest.mark.fast

MOST_DATA, MOST_PUBLIC, MOST_LINES = 15, 20, 60
TEMPLATE = re.compile(r"<[^<>]*(?:<[^<>]*>[^<>]*)*>")


def code(path):
    """The text of a source without comments and strings."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", path.read_text(), flags=re.S)
    return re.sub(r'"(\\.|[^"\\\n])*"', '""', text)


def sources(folder, suffix):
    return sorted((harness.ROOT / folder).rglob("*" + suffix))


def block(text, start):
    """What stands between the brace before `start` and its partner."""
    depth, end = 1, start
    while depth:
        depth += {"{": 1, "}": -1}.get(text[end], 0)
        end += 1
    return text[start:end - 1]


def declarations(body):
    """The declarations of a class, with what is in braces cut out."""
    found, depth, now = [], 0, ""
    for letter in body:
        depth += (letter == "{") - (letter == "}")
        if depth == 0 and letter == ";":
            found.append(now)
            now = ""
        elif depth == 0 and letter == "}" and re.search(r"\)\s*(const|noexcept|override|\s)*(:[^;]*)?\{$", now):
            found.append(now)
            now = ""
        elif depth == 0 or (depth == 1 and letter == "{"):
            now += letter
    return found


def members(body):
    """Numbers of data members and of public functions of a class."""
    access, data, public = "private", 0, 0
    for text in declarations(body):
        text = text.strip()
        while given := re.match(r"(public|private|protected)\s*:\s*", text):
            access, text = given[1], text[given.end():]
        if not text or re.match(r"(using|friend|enum|static_assert|static constexpr|struct \w+\s*(\{\}?)?$|class|typedef)", text):
            continue
        plain = TEMPLATE.sub("", re.sub(r"=.*|\{.*", "", text, flags=re.S))
        if "(" in plain:
            public += access == "public"
        else:
            data += 1 + plain.count(",")
    return data, public


def classes():
    """Name, data members and public functions of each class."""
    for path in sources("include", ".hpp") + sources("src", ".cpp"):
        text = code(path)
        for found in re.finditer(r"\bclass\s+(\w+)[^;{}()]*\{", text):
            yield found[1], *members(block(text, found.end()))


def test_members(expect):
    counted = list(classes())
    expect("classes", len(counted), at_least=40)
    much = [f"{name} {data}" for name, data, _ in counted if data > MOST_DATA]
    expect.that(f"no class of more than {MOST_DATA} data members", not much, ", ".join(much))
    wide = [f"{name} {public}" for name, _, public in counted if public > MOST_PUBLIC]
    expect.that(f"no class of more than {MOST_PUBLIC} public functions", not wide, ", ".join(wide))


def test_one_source(expect):
    """The functions of a class are in one file."""
    homes = {}
    for path in sources("src", ".cpp"):
        for name in re.findall(r"^[\w:<>*& ]*?\b([A-Z]\w+)::~?\w+\([^;]*$", code(path), re.M):
            homes.setdefault(name, set()).add(path.name)
    spread = [f"{name} {len(files)}" for name, files in homes.items() if len(files) > 1]
    expect.that("every class has one source", not spread, ", ".join(sorted(spread)))


def test_functions_fit_on_a_screen(expect):
    long = []
    for path in sources("src", ".cpp") + sources("include", ".hpp"):
        lines = path.read_text().splitlines()
        for start, line in enumerate(lines):
            if line == "{" and start and re.search(r"\)( const| override| noexcept)*$|^\s+: ", lines[start - 1]):
                length = lines[start:].index("}") if "}" in lines[start:] else 0
                if length > MOST_LINES:
                    long.append(f"{path.name}:{start} {length}")
    expect.that(f"no function of more than {MOST_LINES} lines", not long, ", ".join(long))
