"""Writes the tables of studies (see studies_page.py) into a Markdown document, between marks, and compares them with what is there."""

END_MARK = "<!-- end -->"
ROW_HEADER = ["figure", "seen", "goal"]


def begin_mark(name):
    return f"<!-- {name}: written by make verify -->"


def tables(study):
    """The study's tables, and its rows as the last one, as Markdown."""
    parts = [table(each["header"], each["cells"]) for each in study["tables"]]
    if study["rows"]:
        parts.append(table(ROW_HEADER, [[line["name"], line["seen"], line["goal"] or "-"] for line in study["rows"]]))
    return "\n\n".join(parts)


def table(header, cells):
    lines = [header, ["---"] * len(header), *cells]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def split(document, name):
    """The document before, within and after the marks of a study; None where it has none."""
    before, mark, rest = document.partition(begin_mark(name) + "\n")
    within, end, after = rest.partition(END_MARK)
    return (before + mark, within, end + after) if mark and end else None


def fill_in(document, studies):
    """The document with what stands between the marks of each study written anew."""
    for study in studies:
        parts = split(document, study["name"])
        if parts:
            document = parts[0] + tables(study) + "\n" + parts[2]
    return document


def rows_of(text):
    """(name, goal) of the rows of figures in what stands between two marks."""
    lines = text.partition(table(ROW_HEADER, []))[2].splitlines()
    cells = [line.removeprefix("| ").removesuffix(" |").split(" | ") for line in lines if line]
    return [(line[0].replace("\\|", "|"), line[-1].replace("\\|", "|")) for line in cells]


def differences(document, studies):
    """Lines about studies without a place in the document, and about rows that only it or only the study has."""
    lines = []
    for study in studies:
        parts = split(document, study["name"])
        if not parts:
            lines.append(f"{study['name']} has no place")
            continue
        written = rows_of(parts[1])
        computed = [(line["name"], line["goal"] or "-") for line in study["rows"]]
        lines += [f"{study['name']} lacks: {name} ({goal})" for name, goal in computed if (name, goal) not in written]
        lines += [f"{study['name']} still has: {name} ({goal})" for name, goal in written if (name, goal) not in computed]
    return lines
