"""Checks the analytic solutions against their equations, and runs the other scripts on made-up results."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
import pytest

import analytic
import figures
import plot
from mlgimp import fields, pictures, results
from mlgimp.errors import Error

pytestmark = pytest.mark.fast

HISTORY = ("step,time,depth,load,contact_points,contact_half_width,kinetic_energy,strain_energy,"
           "dissipated_energy,external_work,indenter_work,momentum_x,momentum_y,support_impulse_x,"
           "support_impulse_y,mass,points").split(",")
MICRON = 1e-6


# ---- made-up results ----

def nested_boxes(levels):
    """Returns boxes [levels][lower, upper][2] m under the tip at (0, 0), each half as large as the last."""
    sizes = 16 * MICRON / 2.0 ** np.arange(levels)
    return np.array([[(-size, -size), (size, 0)] for size in sizes])


def level_points(boxes, level, cells):
    """Returns the datasets of a level: the points of its box, the next one left out, under a line load."""
    lower, upper = boxes[level]
    half = (upper - lower) / cells / 2
    middles = [lower[axis] + half[axis] * (2 * np.arange(cells) + 1) for axis in (0, 1)]
    x, y = (each.ravel() for each in np.meshgrid(*middles))
    owned = np.ones(x.shape, bool)
    if level + 1 < len(boxes):
        (left, bottom), (right, top) = boxes[level + 1]
        owned = ~((x > left) & (x < right) & (y > bottom) & (y < top))
    position = np.column_stack([x, y])[owned]
    count = len(position)
    return {"id": np.arange(count), "position": position, "velocity": np.zeros((count, 2)),
            "stress": line_load_stress(position - (0, MICRON / 2)), "volume": np.full(count, 4 * half.prod()),
            "deformation_gradient": np.tile([1.0, 0, 0, 1], (count, 1)), "mass": np.ones(count),
            "half_size": np.tile(half, (count, 1)), "body": np.zeros(count, int), "contact_pressure": np.zeros(count), "faces": np.full(count, 8)}


def line_load_stress(place):
    """Returns the stress [n][4] Pa at places [n][2] m from a line load of 5 kN/m (Flamant)."""
    x, y = place.T
    xx, yy, xy = 2 / np.pi * 5e3 * y / (x**2 + y**2) ** 2 * np.array([x**2, y**2, x * y])
    return np.column_stack([xx, yy, 0.3 * (xx + yy), xy])


def write_frame(path, seconds, levels):
    """Writes a list of datasets by level as one frame."""
    with h5py.File(path, "w") as file:
        file.attrs.update(time=seconds, step=int(seconds * 1e12))
        for number, datasets in enumerate(levels):
            for name, values in datasets.items():
                file[f"level_{number}/{name}"] = values


def write_history(path, indenter=True, rows=200):
    """Writes a history whose energies balance but for a residual of 1e-3 of the indenter's work."""
    seconds = np.linspace(0, 22.5e-9, rows)
    depth = 20 * seconds * indenter
    load = 1.5e4 * depth
    work = 0.5 * load * depth
    columns = dict.fromkeys(HISTORY, np.zeros(rows))
    columns |= {"step": np.arange(rows), "time": seconds, "depth": depth, "load": load, "indenter_work": work,
                "kinetic_energy": 1e-11 + 0.1 * work, "strain_energy": 0.7 * work,
                "dissipated_energy": 0.201 * work}
    table = np.column_stack([columns[name] for name in HISTORY])
    np.savetxt(path, table, delimiter=",", header=",".join(HISTORY), comments="", fmt="%.12g")


def write_results(directory, levels=3, cells=24, frame_count=2, indenter=True):
    """Writes a whole result folder and returns its path."""
    directory.mkdir(parents=True)
    boxes = nested_boxes(levels)
    data = [level_points(boxes, level, cells) for level in range(levels)]
    for number in range(frame_count):
        write_frame(directory / f"points_{number:06d}.h5", 22.5e-9 * (number + 1) / frame_count, data)
    write_history(directory / "history.csv", indenter)
    described = [{"lower": list(lower), "upper": list(upper)} for lower, upper in boxes]
    (directory / "summary.json").write_text(json.dumps({"case": "wedge", "levels": described}))
    return directory


# ---- analytic.py ----

def slope(function, at, step):
    """Returns the derivative of a function by central differences of fourth order."""
    near, far = (function(at + n * step) - function(at - n * step) for n in (1, 2))
    return (8 * near - far) / (12 * step)


class Moduli(unittest.TestCase):
    def test_moduli_agree_with_each_other(self):
        lam, mu = analytic.lame_constants(200.0, 0.3)
        self.assertAlmostEqual(mu * (3 * lam + 2 * mu) / (lam + mu), 200)
        self.assertAlmostEqual(lam / (2 * (lam + mu)), 0.3)
        self.assertAlmostEqual(analytic.confined_modulus(200.0, 0.3), 200 * 0.7 / (1.3 * 0.4))
        plane = analytic.plane_strain_modulus(200.0, 0.3)
        self.assertAlmostEqual(plane, 4 * mu * (lam + mu) / (lam + 2 * mu))

    def test_small_strain_gives_hookes_law(self):
        strain = 1e-7 * np.array([[2, 0.5], [0.5, -1]])
        lam, mu = analytic.lame_constants(200.0, 0.3)
        hooke = lam * np.trace(strain) * np.eye(2) + 2 * mu * strain
        np.testing.assert_allclose(analytic.neo_hookean_stress(np.eye(2) + strain, 200.0, 0.3), hooke, 1e-5)


class Manufactured(unittest.TestCase):
    solution = analytic.ManufacturedSolution()
    X = np.random.default_rng(1).uniform(0.02, 0.98, (50, 2))
    t = 0.0031

    def deformation_gradient(self, X):
        """Returns F [n][2][2] at X [n][2] by differences of the displacement."""
        columns = [slope(lambda s: self.solution.displacement(X + s * e, self.t), 0, 1e-3) for e in np.eye(2)]
        return np.eye(2) + np.stack(columns, axis=-1)

    def nominal_stress(self, X):
        """Returns the first Piola-Kirchhoff stress J sigma F^-T, array [n][2][2] in Pa."""
        F = self.deformation_gradient(X)
        sigma = analytic.neo_hookean_stress(F, self.solution.youngs_modulus, self.solution.poissons_ratio)
        return np.linalg.det(F)[:, None, None] * sigma @ np.swapaxes(np.linalg.inv(F), -1, -2)

    def test_stretches_are_the_gradient_of_the_displacement(self):
        F = self.deformation_gradient(self.X)
        np.testing.assert_allclose(F[:, [0, 1], [0, 1]], self.solution.stretches(self.X, self.t), atol=1e-8)
        np.testing.assert_allclose(F[:, [0, 1], [1, 0]], 0, atol=1e-12)

    def test_body_force_balances_momentum(self):
        P_i = [slope(lambda s: self.nominal_stress(self.X + s * e)[:, :, j], 0, 1e-3)
               for j, e in enumerate(np.eye(2))]
        acceleration = slope(lambda t: self.solution.velocity(self.X, t), self.t, 1e-5)
        needed = acceleration - sum(P_i) / self.solution.density
        given = self.solution.body_acceleration(self.X, self.t)
        np.testing.assert_allclose(given, needed, atol=1e-6 * np.max(np.abs(given)))

    def test_velocity_rollers_and_period(self):
        velocity = slope(lambda t: self.solution.displacement(self.X, t), self.t, 1e-5)
        np.testing.assert_allclose(self.solution.velocity(self.X, self.t), velocity, rtol=1e-8)
        corners = np.array([[0, 0], [1, 1]])
        np.testing.assert_allclose(self.solution.displacement(corners, self.t), 0, atol=1e-15)
        np.testing.assert_allclose(self.solution.displacement(self.X, 0.02), 0, atol=1e-15)


class Bars(unittest.TestCase):
    rate = dict(length=0.8, wave_speed=3.0)
    vibrating = analytic.VibratingBar(**rate, peak_velocity=0.2)
    ramped = analytic.RampedBar(**rate, modulus=7.0, traction=0.5, rise_time=0.15)

    def test_vibrating_bar_solves_the_wave_equation(self):
        bar, x, t = self.vibrating, np.linspace(0, 0.8, 9), 0.37
        acceleration = slope(lambda t: bar.velocity(x, t), t, 1e-3)
        curvature = slope(lambda x: slope(lambda x: bar.displacement(x, t), x, 1e-2), x, 1e-2)
        np.testing.assert_allclose(acceleration, 9 * curvature, atol=1e-6 * np.max(np.abs(acceleration)))
        velocity = slope(lambda t: bar.displacement(x, t), t, 1e-3)
        np.testing.assert_allclose(velocity, bar.velocity(x, t), atol=1e-9)
        np.testing.assert_allclose(bar.velocity(x, 0), 0.2 * np.sin(np.pi * x / 1.6))
        self.assertEqual(bar.displacement(0, t), 0)
        self.assertAlmostEqual(slope(lambda x: bar.displacement(x, t), 0.8, 1e-3), 0, places=12)

    def test_ramped_bar_solves_the_wave_equation(self):
        bar, h = self.ramped, 1e-4
        x, t = np.meshgrid(np.linspace(0.05, 0.75, 8), np.linspace(0.013, 2.017, 41))
        velocity, stress = bar.velocity(x, t), bar.stress(x, t)
        np.testing.assert_allclose(slope(lambda t: bar.displacement(x, t), t, h), velocity, atol=5e-4)
        np.testing.assert_allclose(7 * slope(lambda x: bar.displacement(x, t), x, h), stress, atol=5e-4)
        acceleration = slope(lambda t: bar.velocity(x, t), t, h)
        balanced = np.isclose(acceleration * 7 / 9, slope(lambda x: bar.stress(x, t), x, h), atol=1e-8)
        self.assertGreater(balanced.mean(), 0.98)  # all but places at a kink of the ramp
        self.assertGreater(np.mean(acceleration > 0.1), 0.2)
        np.testing.assert_array_equal(bar.displacement(x, 0), 0)
        np.testing.assert_array_equal(bar.velocity(x, 0), 0)

    def test_ramped_bar_meets_its_ends_and_its_mean(self):
        bar, t = self.ramped, np.linspace(0, 50, 4001)
        np.testing.assert_allclose(bar.stress(0.8, t), bar.ramp(t), atol=1e-12)
        np.testing.assert_allclose(bar.displacement(0, t), 0, atol=1e-12)
        period = 4 * 0.8 / 3
        settled = bar.end_displacement(np.linspace(10, 10 + period, 1000, endpoint=False))
        self.assertAlmostEqual(settled.mean(), 0.5 * 0.8 / 7, places=6)
        early = np.linspace(0, 0.5, 21)  # before the echo: velocity = c sigma/M at the end
        np.testing.assert_allclose(bar.velocity(0.8, early), 3 / 7 * bar.ramp(early), atol=1e-14)


class Contact(unittest.TestCase):
    a, modulus = 0.4, 9.0
    cylinder = analytic.cylinder_contact(a, modulus, radius=5.0)
    wedge = analytic.wedge_contact(a, modulus, slope=0.36)
    punch = analytic.flat_punch_contact(a, load=2.0)
    contacts = cylinder, wedge, punch

    def test_pressure_adds_up_to_the_load(self):
        for contact in self.contacts:
            x, weights = contact._quadrature()
            self.assertAlmostEqual(2 * contact.pressure(x) @ weights / contact.load, 1, places=9)
            np.testing.assert_array_equal(contact.pressure(np.array([-0.41, 0.4, 7])), 0)

    def test_stress_on_the_axis_against_closed_forms(self):
        a, d = self.a, np.geomspace(1e-4, 40, 30)
        r = np.hypot(a, d)
        peak = self.cylinder.pressure(0)
        xx, yy = self.cylinder.axis_stress(-d)  # Johnson (4.46)
        np.testing.assert_allclose(yy, -peak * a / r, rtol=1e-9)
        expected = -peak / a * ((a**2 + 2 * d**2) / r - 2 * d)
        np.testing.assert_allclose(xx, expected, rtol=1e-9, atol=1e-12 * peak)
        flat = -2 / np.pi * (r**2 + d**2) / r**3
        np.testing.assert_allclose(self.punch.axis_stress(-d)[1], flat, rtol=1e-9)
        sharp = -9 * 0.36 / np.pi * (np.arcsinh(a / d) + a / r)  # a wedge is a sum of flat punches
        np.testing.assert_allclose(self.wedge.axis_stress(-d)[1], sharp, rtol=1e-9)

    def test_stress_at_the_surface_is_the_pressure(self):
        for contact in (self.cylinder, self.punch):
            xx, yy = contact.axis_stress(-1e-6 * self.a)
            np.testing.assert_allclose([xx, yy], -contact.pressure(0), rtol=1e-5)
        near = np.array([1e-5, 1e-4]) * self.a  # the wedge's is singular like its pressure, a constant apart
        rise, pressure_rise = np.diff(self.wedge.axis_stress(-near)[1]), np.diff(self.wedge.pressure(near))
        np.testing.assert_allclose(rise, -pressure_rise, rtol=1e-6)

    def test_far_away_only_the_load_counts(self):
        for contact in self.contacts:
            xx, yy = contact.axis_stress(-1e4 * self.a)
            self.assertAlmostEqual(yy * np.pi * 1e4 * self.a / (-2 * contact.load), 1, places=6)
            self.assertLess(abs(xx / yy), 1e-6)

    def test_surface_takes_the_shape_of_the_indenter(self):
        """The surface's slope, (2/pi E*) pv int p(s)/(x - s) ds, is that of the indenter, x/R or tan b.

        With p = g/sqrt(a^2 - s^2) the principal value is that of g(s) - g(x), as that of a constant g is 0.
        """
        x, a = 0.55 * self.a, self.a
        for contact, face_slope in (self.cylinder, x / 5), (self.wedge, 0.36):
            s, weights = contact._quadrature()
            root = np.sqrt(a**2 - s**2)
            g, g_x = contact.pressure(s) * root, contact.pressure(x) * np.sqrt(a**2 - x**2)
            integral = 2 * x * ((g - g_x) / (x**2 - s**2) / root) @ weights
            self.assertAlmostEqual(2 / (np.pi * self.modulus) * integral, face_slope, places=9)


# ---- results.py, plot.py, figures.py ----

class Crystals(unittest.TestCase):
    """Indentation moduli by the integral of Barnett and Lothe."""

    def test_isotropic_half_space(self):
        lam, mu = analytic.lame_constants(110, 0.25)
        found = analytic.indentation_modulus(analytic.stiffness_tensor([lam + 2 * mu, lam, mu]), (1, 2, 3))
        self.assertLess(abs(found / analytic.plane_strain_modulus(110, 0.25) - 1), 1e-10)

    def test_basal_plane(self):
        zinc = (163.7, 36.4, 53, 63.5, 38.8)
        found = analytic.indentation_modulus(analytic.stiffness_tensor(zinc), (0, 0, 1))
        self.assertLess(abs(found / analytic.hexagonal_indentation_modulus(*zinc) - 1), 1e-10)

    def test_fewer_directions_give_the_same(self):
        quartz = analytic.stiffness_tensor((86.8, 7.0, 11.9, 105.8, 58.2, -18.0))
        few, many = (analytic.indentation_modulus(quartz, (1, 2, 3), directions) for directions in (60, 180))
        self.assertLess(abs(few / many - 1), 1e-10)


class Scripts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.root = Path(cls.temporary.name)
        cls.three = write_results(cls.root / "three")
        cls.one = write_results(cls.root / "one", levels=1, frame_count=1, indenter=False)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def run_quietly(self, main, *arguments):
        """Runs the main function of a script and returns what it printed."""
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            main([str(each) for each in arguments])
        return printed.getvalue()

    def assert_picture(self, path):
        """Passes for a picture with more than one colour."""
        self.assertGreater(np.ptp(pictures.plt.imread(path)), 0.5, path)

    def test_reader_returns_what_was_written(self):
        history = results.read_history(self.three)
        self.assertEqual(list(history), HISTORY)
        self.assertEqual(history["time"][-1], 22.5e-9)
        work = history["indenter_work"]
        np.testing.assert_allclose(results.energy_residual(history), 1e-3 * work, atol=1e-12 * work[-1])
        names = [path.name for path in results.numbered_frames(self.three).values()]
        self.assertEqual(names, ["points_000000.h5", "points_000001.h5"])
        frame = results.read_frame(results.find_frame(self.three))
        self.assertEqual((frame.time, frame.step, len(frame.levels)), (22.5e-9, 22500, 3))
        points = results.all_points(frame.levels)
        self.assertAlmostEqual(points["volume"].sum() / (32 * 16 * MICRON**2), 1)
        counts = [len(each["id"]) for each in frame.levels]
        np.testing.assert_array_equal(np.bincount(points["level"]), counts)
        np.testing.assert_allclose(results.level_boxes(results.read_summary(self.three)), nested_boxes(3))

    def test_reader_takes_empty_levels_and_more_than_ten(self):
        full = level_points(nested_boxes(1), 0, 4)
        empty = {name: values[:0] for name, values in full.items()}
        path = self.root / "levels.h5"
        write_frame(path, 1e-9, 10 * [empty] + [full, empty])
        levels = results.read_frame(path).levels
        self.assertEqual([len(each["position"]) for each in levels], 10 * [0] + [16, 0])
        self.assertEqual(results.all_points(levels)["stress"].shape, (16, 4))

    def test_errors_are_one_line(self):
        (self.root / "empty").mkdir()
        folder = write_results(self.root / "damaged", levels=1)
        (folder / "history.csv").write_text("step,time\n0,0\n1\n")
        (folder / "summary.json").write_text("{")
        (folder / "points_000001.h5").write_text("not HDF5")
        for call in (lambda: results.read_history(self.root / "empty"),
                     lambda: results.find_frame(self.root / "empty"),
                     lambda: results.find_frame(self.three, 7),
                     lambda: results.read_history(folder),
                     lambda: results.read_summary(folder),
                     lambda: results.read_frame(results.find_frame(folder)),
                     lambda: figures.read_fem(folder / "history.csv"),
                     lambda: figures.run_curve(self.one, "no indenter")):
            with self.assertRaises(Error) as caught:
                call()
            self.assertRegex(str(caught.exception), r"^[^\n]+$")

    def test_plot_draws_all_pictures(self):
        out = self.root / "pictures"
        self.run_quietly(plot.main, self.three, "--out", out, "--frame", 0, "--window=-4e-6,4e-6,-6e-6,0")
        names = ["contact_pressure.png", "energy.png", "load_depth.png", "stress_xx.png", "stress_xy.png", "stress_yy.png"]
        self.assertEqual(sorted(path.name for path in out.iterdir()), names)
        for path in out.iterdir():
            self.assert_picture(path)

    def test_plot_without_indenter_draws_the_rest(self):
        (self.one / "summary.json").unlink()
        printed = self.run_quietly(plot.main, self.one)
        self.assertIn("no load_depth.png", printed)
        self.assertEqual(len(list(self.one.glob("*.png"))), 4)

    def test_surface_under_a_tip(self):
        history = {"tip_x": np.array([1.0, 1.0]), "tip_y": np.array([2.0, 2.0]), "depth": np.array([-0.5, 0.1])}
        np.testing.assert_array_equal(figures.under_tip(history), [1, 1.5])
        np.testing.assert_array_equal(figures.under_tip(history | {"tip_z": np.array([3.0, 2.4])}), [1, 2.5])

    def test_figures_compare_runs(self):
        fem = self.root / "fem.csv"
        fem.write_text("# from elsewhere\ndepth,load\n0,0\n4.5e-7,7e-3\n")
        depth, load = figures.read_fem(fem)
        self.assertEqual((depth[-1], load[-1]), (4.5e-7, 7e-3))
        curves, panels = self.root / "curves.png", self.root / "fields.png"
        self.run_quietly(figures.main, "load-depth", curves, f"{self.three}:three", "--fem", f"{fem}:FEM")
        self.run_quietly(figures.main, "fields", panels, "--component", "xy", f"{self.three}:0:early",
                         f"{self.three}:late")
        self.assert_picture(curves)
        self.assert_picture(panels)

    def test_units_follow_the_magnitude(self):
        for value, symbol, text in ((22.5e-9, "s", "22.5 ns"), (1e-6, "m", "1 µm"), (6e-3, "N", "6 mN"),
                                    (0, "m", "0 m"), (1.2e10, "Pa", "12 GPa"), (-999.0, "Pa", "-999 Pa")):
            self.assertEqual(pictures.in_si_unit(value, symbol), text)

    def test_one_outlier_leaves_the_colours_alone(self):
        values = np.append(np.linspace(-2e6, 1e6, 10000), -1e12)
        scale = fields.colour_scale(values, centred=False)
        self.assertEqual(scale.low, -scale.high)
        self.assertAlmostEqual(scale.high / 2e6, 1, delta=0.02)
        one_sign = fields.colour_scale(np.linspace(1e6, 2e6, 1000), centred=False)
        self.assertGreater(one_sign.low, 0.9e6)
