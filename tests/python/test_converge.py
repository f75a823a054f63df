"""Checks scripts/converge.py: Richardson's figures on exact sequences, its arguments, and two small cases."""

import contextlib
import csv
import io
import math
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
import pytest

import converge
from mlgimp import results
from mlgimp.errors import Error
from mlgimp.pictures import plt

pytestmark = pytest.mark.fast

# A bar between rollers that is pulled slowly and damped: at its end the stress is the traction everywhere.
BAR = """# a comment
-domain_lower 0,0
-domain_upper 24,4
-cell_size 2
-boundary_x_lower symmetry
-boundary_y_lower symmetry
-boundary_y_upper symmetry
-materials rubber
-rubber_youngs_modulus 1e7
-rubber_poissons_ratio 0.3
-rubber_density 1000
-bodies bar
-bar_lower 0,0
-bar_upper 16,4
-loads pull
-pull_side x_upper
-pull_times 0,0.5
-pull_pressures 0,-1e5
-damping 12
-time_step 4e-3
-max_steps 500
"""


def test_loads_belong_between_rows(tmp_path, expect):
    """A load is the mean since the row before: P = h^2 at any depth, also the last, from rows far apart."""
    edges = np.linspace(0, 1, 11)
    columns = {name: np.zeros(11) for name in results.HISTORY_COLUMNS} | {"depth": edges, "load": np.append(0, np.diff(edges**3) / np.diff(edges) / 3)}
    (tmp_path / "history.csv").write_text("\n".join([",".join(columns), *(",".join(map(repr, map(float, row))) for row in zip(*columns.values()))]) + "\n")
    for depth in (0.35, 0.5, 0.97, 1.0):
        own = converge.Study("case", 2, "load", depth, False, None, 1)
        expect(f"load at depth {depth}", converge.history_value(tmp_path, own), near=depth**2, tolerance=0.008)
    assert converge.history_value(tmp_path, converge.Study("case", 2, "depth", 0.5, False, None, 1)) == 0.5


class Richardson(unittest.TestCase):
    def test_exact_sequences(self):
        for order in (1, 2, 1.5):
            values = [3 + 0.7 * 2 ** (-order * k) for k in range(4)]
            difference, found, limit, error = converge.richardson(values)
            self.assertAlmostEqual(found, order)
            self.assertAlmostEqual(limit, 3)
            self.assertAlmostEqual(error, values[-1] - 3)
            self.assertAlmostEqual(difference, values[-1] - values[-2])

    def test_an_order_above_the_methods_is_not_trusted(self):
        difference, found, limit, error = converge.richardson([1, 1.8, 1.9])
        self.assertAlmostEqual(found, 3)
        self.assertAlmostEqual(error, 0.1 / 3)
        self.assertAlmostEqual(limit, 1.9 + 0.1 / 3)

    def test_nothing_follows_where_differences_do_not_shrink(self):
        for values in ([1], [1, 2], [1, 2, 3], [1, 2, 1.5], [1, 2, 4], [1, 1, 1], [1, 2, 2]):
            self.assertTrue(all(math.isnan(figure) for figure in converge.richardson(values)[1:3]), values)
            spread = max(values) - min(values) if len(values) == 3 else math.nan
            np.testing.assert_equal(converge.richardson(values)[3], spread)

    def test_a_sentence_says_why_there_is_no_order(self):
        for values, words in (([1, 2], "-refine 3"), ([1, 2, 1.5], "goes up and down.* apart, 1 .67 % of the last"), ([1, 2, 4], "do not shrink"),
                              ([1, 1, 1], "are the same"), ([1, 1.8, 2.0], "^$")):
            self.assertRegex(converge.why_no_order(values), words)


class Stress(unittest.TestCase):
    def test_linear_stress_is_exact_at_any_place(self):
        x, y = (each.ravel() for each in np.meshgrid(np.arange(8) + 0.5, np.arange(6) + 0.5))
        stress = np.column_stack([3 + 2 * x - y, x, 0 * x, 7 * y])
        with tempfile.TemporaryDirectory() as folder:
            with h5py.File(Path(folder) / "points_000001.h5", "w") as file:
                file.attrs.update(time=1.0, step=1)
                for name, values in (("position", np.column_stack([x, y])), ("half_size", np.full((48, 2), 0.5)), ("stress", stress)):
                    file[f"level_0/{name}"] = values
            for place in (np.array([3.3, 2.1]), np.array([0.1, 5.8])):
                self.assertAlmostEqual(converge.stress_at(folder, "xx", place), 3 + 2 * place[0] - place[1])
                self.assertAlmostEqual(converge.stress_at(folder, "xy", place), 7 * place[1])
            with self.assertRaises(Error) as caught:
                converge.stress_at(folder, "xx", np.array([9.6, 2.0]))
        self.assertRegex(str(caught.exception), "^-place 9.6,2: must be inside a body")


class Cases(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.root = Path(cls.temporary.name)
        cls.file = cls.root / "bar.opts"
        cls.file.write_text(BAR)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def study(self, folder, *words):
        """Runs the script; returns its printed lines and the rows of convergence.csv as numbers."""
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            converge.main([str(self.file), "-output_dir", str(self.root / folder), *words])
        with open(self.root / folder / "convergence.csv", newline="") as file:
            rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
        return printed.getvalue().splitlines(), rows

    def test_energy_of_a_bar(self):
        printed, rows = self.study("energy", "-refine", "3", "-quantity", "strain_energy", "-ranks", "2", "-bar_points_per_cell", "1")
        self.assertEqual([row["cell_size_m"] for row in rows], [2, 1, 0.5])
        self.assertEqual([row["points"] for row in rows], [16, 64, 256])
        self.assertEqual([row["steps"] for row in rows], [500, 1000, 2000])
        # Linear elasticity: p^2/2M times the volume; the strain is 0.7 %, the law differs from it by as much.
        modulus = 1e7 * 0.7 / (1.3 * 0.4)
        for row in rows:
            self.assertAlmostEqual(row["value"] / (1e10 / (2 * modulus) * 64), 1, delta=0.015)
        why = converge.why_no_order([row["value"] for row in rows])
        self.assertEqual(len(printed), 2 + 3 + 2 + bool(why))
        self.assertGreater(plt.imread(self.root / "energy" / "convergence.png").std(), 0.05)
        times = [results.read_history(folder)["time"] for folder in sorted((self.root / "energy").glob("cells_*"))]
        for other in times[1:]:
            np.testing.assert_allclose(other, times[0], rtol=1e-12)

    def test_stress_on_two_levels(self):
        levels = ("-levels", "2", "-level_1_lower", "8,0", "-level_1_upper", "24,4", "-max_steps", "400")
        _, rows = self.study("stress", "-refine", "2", "-quantity", "stress_xx", "-place", "12.3,1.7", *levels)
        self.assertEqual([row["steps"] for row in rows], [400, 800])
        self.assertGreater(rows[0]["points"], 32 + 128)  # 8 x 4 m on cells of 2 and of 1 m, and those that have crossed
        self.assertGreater(rows[1]["points"], 4 * (32 + 128))
        for row in rows:
            self.assertAlmostEqual(row["value"] / 1e5, 1, delta=0.02)

    def test_stress_in_other_geometries(self):
        space = ("-geometry", "3d", "-domain_lower", "0,0,0", "-domain_upper", "24,4,4", "-bar_lower", "0,0,0", "-bar_upper", "16,4,4",
                 "-boundary_z_lower", "symmetry", "-boundary_z_upper", "symmetry", "-max_steps", "400")
        for component, place, options in (("xx", "12.3,1.7,2.2", space), ("xx", "7.3,1.7", ("-geometry", "axisymmetric")),
                                          ("zz", "7.3,1.7", ("-geometry", "axisymmetric"))):
            _, rows = self.study(f"{component}{len(place)}", "-refine", "2", "-quantity", f"stress_{component}", "-place", place, *options)
            for row in rows:
                self.assertAlmostEqual(row["value"] / 1e5, 1, delta=0.02)
        with self.assertRaises(SystemExit) as caught:
            self.study("missing", "-refine", "2", "-quantity", "stress_xz", "-place", "12.3,1.7", "-max_steps", "3")
        self.assertRegex(caught.exception.code, "^error: -place 12.3,1.7, -quantity stress_xz: must be those of the case's geometry")

    def test_help_at_any_place_starts_nothing(self):
        for words in (["-h"], [str(self.file), "--help"], [str(self.file), "-refine", "3", "-h"]):
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                converge.main([*words, "-output_dir", str(self.root / "help")] if len(words) > 1 else words)
            self.assertIn("usage: scripts/converge.py", printed.getvalue())
        self.assertFalse((self.root / "help").exists())

    def test_units_and_both_dashes(self):
        own, passed = converge.parse(converge.one_dash([str(self.file), "--refine", "2", "-depth", "190nm", "--frames=3"]))
        self.assertAlmostEqual(own.depth, 190e-9)
        self.assertEqual((own.refine, passed), (2, {"frames": "3"}))
        np.testing.assert_allclose(converge.read_place("1um,2"), [1e-6, 2])

    def test_wrong_arguments_are_one_line(self):
        file = str(self.file)
        bare = self.root / "bare.opts"
        bare.write_text("-max_steps 3\n")
        for words, expected in (([str(self.root / "none.opts")], "no such options file"), ([file, "-refine", "1"], "-refine.*>= 2"),
                                ([file, "-refine", "two"], "-refine.*two"), ([file, "-ranks", "0"], "-ranks.*>= 1"),
                                ([file, "-quantity", "stress_zx"], "stress_xx"), ([file, "-quantity", "stress_xx"], "needs -place"),
                                ([file, "-quantity", "load", "-place", "1,1"], "leave -place out"),
                                ([file, "-quantity", "stress_xx", "-place", "1"], "must be X,Y"),
                                ([file, "-depth", "deep"], "-depth deep: must be a number"), ([file, "-quantity"], r"-quantity \(nothing\)"), ([file, "-refine"], r"-refine \(nothing\)"),
                                ([file, "-maximum", "3"], "without a value"), ([file, "-quantity", "stress_xx", "-place", "-1,1", "-depth", "3"], "only one of"), ([file, "-depth", "1", "-maximum"], "only one of"),
                                ([file, "-cell_size", "small"], "-cell_size small"), ([file, "7"], "7: must follow an option"),
                                ([str(bare)], "must give -cell_size"), ([file, "-bar_uper", "1,1"], "cells of 2.0 m: mlgimp: error: -bar_uper"),
                                ([file, "-quantity", "laod", "-max_steps", "3"], "-quantity laod.*load"),
                                ([file, "-quantity", "load", "-depth", "1", "-max_steps", "3"], "-depth 1: must be in"),
                                ([file, "--quantity=load", "--depth", "1s"], "-depth 1s: must be a number in m, or"),
                                ([file, "-indenter_loads", "0,1"], "prescribes the load"),
                                ([file, "-indenter_control", "load"], "prescribes the load"),
                                ([file, "-indenter", "cone", "-quantity", "depth"], "prescribes the depth"),
                                ([file, "-quantity", "depth", "-depth", "1nm"], "is what -depth gives")):
            with self.assertRaises(SystemExit) as caught, contextlib.redirect_stdout(io.StringIO()):
                converge.main([words[0], *words[1:], "-output_dir", str(self.root / "wrong"), "-overwrite"])
            self.assertRegex(str(caught.exception.code), rf"^error: [^\n]*{expected}[^\n]*$", words)
