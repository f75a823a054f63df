"""Files as instruments write them, tiny and made up, of the curve of made_curves.metal()."""
import zipfile

import numpy as np

from made_curves import metal

MICRO = "\N{MICRO SIGN}"


def columns(rows=60, scale=1.0):
    """Time (s), depth (um) and load (mN) of a test with a loading to 10 mN and an unloading."""
    depth, load = metal(top=0.5 * scale, load=10 * scale**2, final=0.42 * scale, rows=rows)
    return 0.1 * np.arange(len(depth)), depth, load


def table(names, values, mark="\t", comma=False):
    """Text with a line of names and rows."""
    rows = [mark.join(f"{value:.9g}".replace(".", "," if comma else ".") for value in row) for row in np.column_stack(values)]
    return "\n".join([mark.join(names), *rows]) + "\n"


def hysitron_hld():
    """Head with the tip, and tables of approach and drift above that of the test, longer than it."""
    time, depth, load = columns()
    head = ["File Version: Hysitron HighLoad", "Test Type: Indentation", f"Contact Threshold: 250 {MICRO}N",
            "Disp C1L: 59960 nm/V", "Machine Comp: 0.00033 nm/uN",
            "Tip Usable Depth: 1000 nm", "Tip C0: 24.5 nm^2/nm^2", "Tip C1: 500 nm^2/nm", *(f"Tip C{k}: 0 nm^2/nm^0.5" for k in range(2, 6)),
            "Drift Rate: 0.05 nm/s", "Sample Approach Data Points: 300"]
    drift = table(["Time_s", "Disp_nm"], [0.1 * np.arange(300), np.linspace(0, 1, 300)])
    approach = table(["Time_s", "MotorDisp_mm", "Piezo Extension_nm"], [0.1 * np.arange(300), np.zeros(300), np.zeros(300)])
    test = table(["Time_s", "Disp_nm", f"Force_{MICRO}N", "LoadCell_nm", "PiezoDisp_nm", "Disp_V", "Force_V"],
                 [time, 1e3 * depth, 1e3 * load, 0 * time, 0 * time, depth, load])
    return "\n".join(head) + "\n" + approach + "Drift Measurement Data Points: 300\n" + drift + f"Test Data Points: {len(time)}\n" + test


def triboscan():
    time, depth, load = columns()
    names = ["Depth (nm)", f"Load ({MICRO}N)", "Time (s)", "Depth (V)", "Load (V)"]
    return f"Mon Jan 07 10:00:00 2030\n\nNumber of Points = {len(time)}\n" + table(names, [1e3 * depth, 1e3 * load, time, -depth, load / 9])


def nanosuite_rows(scale=1.0, end=True):
    """Rows of a sheet Test 001: names, units, numbers with a marker in the first column, and END."""
    time, depth, load = columns(scale=scale)
    rows = [["Segment", "Displacement Into Surface", "Load On Sample", "Time On Sample", "Harmonic Contact Stiffness", "Hardness"],
            [None, "nm", "mN", "s", "N/m", "GPa"]]
    rows += [["Load Segment Type" if k == 0 else None, 1e3 * h, p, t, 1.7976931348623157e308, 1.7976931348623157e308]
             for k, (t, h, p) in enumerate(zip(time, depth, load))]
    return rows + [["END"]] * end


def nanosuite_csv():
    return "\n".join(",".join("" if cell is None else str(cell) for cell in row) + "," * (6 - len(row)) for row in nanosuite_rows()) + "\n"


def anton_paar(comma=True):
    """The instrument's own results above the curve, numbers in a German or French way."""
    time, depth, load = columns()
    head = ["Indentation", "Indenter type : Berkovich", "Fm  = 10,00 mN", "hm = 500,00 nm", "Hit = 2413,5 MPa", "Eit = 71,2 GPa", ""]
    return "\n".join(head) + "\n" + table(["Time [s]", "Pd [nm]", "Fn [mN]", "Phase"], [time, 1e3 * depth, load, np.ones(len(time))], comma=comma)


def fischer(tests=2):
    """Columns without units, and figures of each block above them."""
    text = "my.hap\tName of the application\n\tApplication comment\nF = 10.000mN/6s\n3900,1\t10,1\t6,0\tHM\tx\ty\n3800,2\t10,2\t6,0\tHM\tx\ty\n"
    for number in range(1, tests + 1):
        time, depth, load = columns()
        text += (f"my.hap   01.02.2030  10:0{number}:00\nIndenter shape correction: Hardness\nBlock : 1   Value : {number}\nx=    10.10  y=     6.00\n"
                 f"HIT\t[N/mm\N{SUPERSCRIPT TWO}]\t   8500.0\n \n20.95%  -  95.33% Fmax     Epsilon = 0.750\n\n"
                 + table("Fht", [load, depth, time], comma=True))
    return text


def nanotest():
    """No names; a time of zero in the approach, whose depths are below zero."""
    time, depth, load = columns()
    before = np.column_stack([np.zeros(12), np.linspace(-300, -5, 12), np.linspace(-0.01, 0, 12)])
    rows = np.vstack([before, np.column_stack([time, 1e3 * depth, load])])
    return "\r\n".join("\t".join(f"{value:.6f}" for value in row) for row in rows) + "\r\n"


def femtotools():
    time, depth, load = columns()
    return "FT-NMT04\nSpring constant [N/m]\t1000\n" + table(["Index", "Time [s]", f"Displacement [{MICRO}m]", f"Force [{MICRO}N]", f"Position Z [{MICRO}m]"],
                                                             [np.arange(len(time)), time, depth, 1e3 * load, 0 * time])


def optics11():
    """Cantilever and radius in the head; the indentation is without the cantilever."""
    time, depth, load = columns()
    head = "Date\t01/02/2030\tTime\t10:00:00\tStatus\tOK\nX-position (um)\t1000.000\nk (N/m)\t4.640\nTip radius (um)\t23.000\n\nControl mode: Displacement\n" \
           "D[Z1] (nm)\t0.000\tt[1] (s)\t0.500\n\nP[max] (uN)\t0.375\nE[eff] (Pa)\t2379.0\n\n"
    return head + table(["Time (s)", "Load (uN)", "Indentation (nm)", "Cantilever (nm)", "Piezo (nm)", "Auxiliary"],
                        [time, 1e3 * load, 1e3 * depth, 200 * load, 1e3 * depth + 200 * load, 0 * time])


def german():
    time, depth, load = columns()
    u = "\N{LATIN SMALL LETTER U WITH DIAERESIS}"
    return table([f"Pr{u}fzeit t (s)", f"Eindringtiefe h ({MICRO}m)", f"Pr{u}fkraft F (mN)"], [time, depth, load], mark=";", comma=True)


def french():
    time, depth, load = columns()
    return table(["Temps (s)", "Profondeur de p\N{LATIN SMALL LETTER E WITH ACUTE}n\N{LATIN SMALL LETTER E WITH ACUTE}tration (nm)", "Force normale (mN)"],
                 [time, 1e3 * depth, load], mark=";", comma=True)


TEXTS = {"hysitron.hld": hysitron_hld, "triboscan.txt": triboscan, "nanosuite.csv": nanosuite_csv, "anton_paar.TXT": anton_paar, "fischer.txt": fischer,
         "nanotest.txt": nanotest, "femtotools.txt": femtotools, "optics11.txt": optics11, "german.txt": german, "french.txt": french}


def write_xlsx(path, sheets):
    """Writes {name: rows} as a workbook."""
    import openpyxl
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)


RESULTS = [["Test", "E", "Displacement", "Load"], ["", "GPa", "nm", "mN"], *([k, 72.0, 500.0, 10.0] for k in range(1, 20))]  # a sheet that is no test


def write_zip(path, texts):
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in texts.items():
            archive.writestr(name, text)
