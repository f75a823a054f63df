"""Sheets of workbooks (.xls, .xlsx), texts in archives and tables in HDF5 files, as lines of text with tabs between the columns, as an
instrument's text export has them."""

import importlib
import io
import zipfile

import h5py

from . import tables
from .errors import ResultError

OLD, ZIPPED, HDF5 = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", b"PK\x03\x04", b"\x89HDF\r\n\x1a\n"  # first bytes of .xls, of .xlsx and other archives
PACKAGES = {"xlrd": "python3-xlrd", "openpyxl": "python3-openpyxl"}  # of Debian


def is_workbook(content):
    """Whether a file's bytes are those of a workbook, an archive or an HDF5 file."""
    return content.startswith((OLD, ZIPPED, HDF5))


def lines_of_sheets(path, content):
    """Yields (name, lines of text) for each sheet of a workbook, each text in an archive, or each group with columns in an HDF5 file."""
    try:
        if content.startswith(OLD):
            yield from old_sheets(path, content)
        elif content.startswith(HDF5):
            yield from groups(content)
        else:
            with zipfile.ZipFile(io.BytesIO(content)) as archive:
                names = archive.namelist()
            yield from (new_sheets(path, content) if "xl/workbook.xml" in names else texts_in(path, content, names))
    except ResultError:
        raise
    except Exception as problem:  # what the readers raise for a damaged file is of many kinds
        raise ResultError(path, f"cannot be read as a workbook ({' '.join(str(problem).split())[:80] or type(problem).__name__})") from None


def module(path, name):
    """Returns a module that reads workbooks; a ResultError says which package has it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ResultError(path, f"is a workbook, and this Python has no module {name}: install {PACKAGES[name]} (or pip install {name}), "
                                "or export the test as text") from None


def old_sheets(path, content):
    """Yields (name, lines) of the sheets of a .xls."""
    book = module(path, "xlrd").open_workbook(file_contents=content, on_demand=True, logfile=io.StringIO())
    for name in book.sheet_names():
        sheet = book.sheet_by_name(name)
        yield name, [line_of(sheet.row_values(row)) for row in range(sheet.nrows)]
        book.unload_sheet(name)


def new_sheets(path, content):
    """Yields (name, lines) of the sheets of a .xlsx."""
    book = module(path, "openpyxl").load_workbook(io.BytesIO(content), read_only=True, data_only=True)
    for sheet in book.worksheets:
        yield sheet.title, [line_of(row) for row in sheet.iter_rows(values_only=True)]


def texts_in(path, content, names):
    """Yields (name, lines) of the texts in an archive."""
    texts = [name for name in names if name.lower().endswith((".txt", ".csv", ".dat"))]
    if not texts:
        raise ResultError(path, "is an archive without a workbook or texts in it")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        for name in texts:
            yield name, tables.decoded(path, archive.read(name)).splitlines()


def groups(content):
    """Yields (name, lines) of the groups of an HDF5 file that hold columns, by the name of the outermost group; a unit is an attribute."""
    found = []
    with h5py.File(io.BytesIO(content), "r") as file:
        file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Group) else None)
        for name in found:
            columns = {key: item for key, item in file[name].items() if isinstance(item, h5py.Dataset) and item.ndim == 1 and len(item) > 1}
            if len({len(item) for item in columns.values()}) == 1 and len(columns) > 1:
                heads = [f"{key} ({text_of(item.attrs['unit'])})" if "unit" in item.attrs else key for key, item in columns.items()]
                yield name.split("/")[0], [line_of(heads), *map(line_of, zip(*(item[:].tolist() for item in columns.values())))]


def text_of(value):
    """Returns an attribute as text."""
    return value.decode() if isinstance(value, bytes) else str(value)


def line_of(cells):
    """Returns the cells of a row as a line: numbers as Python writes them, nothing for an empty cell, words for what is no number
    in a curve, as 1.8e308 of NanoSuite."""
    return "\t".join("" if cell is None else "no value" if isinstance(cell, float) and not abs(cell) < tables.LARGEST else " ".join(str(cell).split())
                     for cell in cells)
