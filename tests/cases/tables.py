"""Studies that need a body force or initial velocities which no option offers: tables and checks of the programs bin/test_*."""
import math
import subprocess

import harness
import studies_page as page

ORDER_GOAL = 1.8  # of the rms error on one level


def table(study, program, *arguments):
    """Header and cells of the table that a program prints; its command is that of the figures that follow."""
    command = [f"bin/{program}", "table", *map(str, arguments)]
    study.command = " ".join(command)
    done = subprocess.run(command, cwd=harness.ROOT, capture_output=True, text=True, env=harness.ENVIRONMENT, check=True)
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines() if line.startswith("|")]
    return lines[0], lines[2:]


def check(study, program):
    """Takes over what the tests of a program expect, and print in lines that begin with ok or FAIL."""
    study.command = f"bin/{program}"
    ran = harness.run_units(program)
    for line in ran.output.splitlines():
        word, _, rest = line.partition(" ")
        if word in ("ok", "FAIL"):
            name, _, detail = rest.partition(": ")
            study.expect.that(f"{program}: {name}", word == "ok", detail)
    if ran.status != 0:
        study.expect.that(program, False, f"exit status {ran.status}: {ran.error.strip()[-500:]}")


def order(errors, coarse, fine):
    """Mean order between two numbers of cells."""
    return math.log2(errors[coarse] / errors[fine]) / math.log2(fine / coarse)


def error_curves(errors):
    """Curves of errors over cell size, of {label: {n: error}}, between guides of order 1 and 2."""
    curves = [page.curve(label, [1 / n for n in of], of.values(), "points") for label, of in errors.items()]
    sizes = sorted(1 / n for n in next(iter(errors.values())))
    least = min(error for of in errors.values() for error in of.values() if error > 0)
    return curves + [page.slope(power, sizes, 0.5 * least) for power in (1, 2)]


def plot_errors(study, title, largest, rms):
    for kind, errors in (("largest", largest), ("rms", rms)):
        study.plot(f"{title}: {kind} error", "cell size / side of the square", f"{kind} error / side of the square",
                    *error_curves(errors), log=True)


def verify_manufactured(study):
    """Manufactured solution on one level

    The axis-aligned solution of Wallstedt & Guilkey (2008), amplitude 0.05 of the square's side, one period; the worst
    error of all steps, over points, in lengths of the side.
    """
    largest, rms = {}, {}
    for variant, n, largest_error, _, rms_error, _ in table(study, "test_manufactured", 128)[1]:
        if int(n) >= 16:
            largest.setdefault(variant, {})[int(n)] = float(largest_error)
            rms.setdefault(variant, {})[int(n)] = float(rms_error)
    for variant in ("cpGIMP USL", "cpGIMP MUSL XPIC(2) 10 %", "cpGIMP default", "cpGIMP default, volume average"):
        study.expect(f"manufactured, {variant}: order of the rms error, n = 16..128", order(rms[variant], 16, 128), at_least=ORDER_GOAL)
        study.figure(f"manufactured, {variant}: order of the max error, n = 16..128", order(largest[variant], 16, 128))
    original = rms["original MPM USL"]
    study.expect.that("manufactured, original MPM does not converge", not original[128] < 0.5 * original[16])
    study.table("Errors at n = 16 / 32 / 64 / 128", ["variant", "max error, n = 16 / 32 / 64 / 128", "rms error, n = 16 / 32 / 64 / 128"],
                 [[variant, *(" / ".join("fails" if math.isnan(error) else f"{error:.1e}" for error in of[variant].values())
                              for of in (largest, rms))] for variant in rms])
    plot_errors(study, "One level", largest, rms)


def verify_manufactured_levels(study):
    """Manufactured solution across borders of levels

    The same solution with a finer level in half of the square, in its middle, and with three levels; n counts coarse cells.
    """
    check(study, "test_levels_manufactured")
    largest, rms = {}, {}
    for levels, ratio, scheme, n, largest_error, _, rms_error, *_ in table(study, "test_levels_manufactured", 64)[1]:
        name = levels if levels == "one level" else f"{levels}, ratio {ratio}"
        largest.setdefault((name, scheme), {})[int(n)] = float(largest_error)
        rms.setdefault((name, scheme), {})[int(n)] = float(rms_error)
    study.table("Errors and orders", ["levels", "scheme", "max error at n = 64", "its order, n = 16..64", "rms error at n = 64", "its order"],
                 [[*case, f"{largest[case][64]:.1e}", f"{order(largest[case], 16, 64):.2f}", f"{rms[case][64]:.1e}",
                   f"{order(rms[case], 16, 64):.2f}"] for case in rms])
    default = {name: (largest[name, scheme], rms[name, scheme]) for name, scheme in rms if scheme == "default"}
    drawn = [name for name in default if name == "one level" or name.endswith("ratio 2")]
    plot_errors(study, "Levels, default settings", *({name: default[name][kind] for name in drawn} for kind in (0, 1)))


def verify_manufactured_space(study):
    """Manufactured solution in space

    The same along three axes, on one level and with a finer level in the cube's middle; n counts coarse cells along its side.
    """
    rms, cells = {}, table(study, "test_levels_manufactured", -32)
    for levels, _, _, n, _, _, rms_error, *_ in cells[1]:
        rms.setdefault(levels, {})[int(n)] = float(rms_error)
    for levels, errors in rms.items():
        study.expect(f"manufactured, {levels}: order of the rms error, n = 8..{max(errors)}", order(errors, 8, max(errors)), at_least=ORDER_GOAL)
    study.table("Errors and orders", *cells)


def verify_radial(study):
    """Axisymmetry against exact solutions

    A stretched patch, radial motion, the first radial mode between the axis and a wall (on two levels with the border half
    way), a free cylinder, and a manufactured solution with a radial amplitude of 0.05; errors in radii of the wall, E/E0 and
    phase after 20 periods.
    """
    check(study, "test_radial")
    study.table("By the number of (coarse) cells to the wall", *table(study, "test_radial", 64))


def verify_free_block(study):
    """Energy of a free vibrating block

    E/E0 after 20 periods, each the mean over a period, on 24 x 24 cells; the rotating block turns by 2 rad.
    """
    header, cells = table(study, "test_vibration")
    study.table("E/E0 after 20 periods", header, cells)
    for strain, energy in zip(header[1:], next(line for line in cells if "(default)" in line[0])[1:]):
        study.expect(f"default, {strain}: E/E0 after 20 periods", float(energy), at_least=0.97)


def verify_block_on_levels(study):
    """Energy of a block that vibrates across borders of levels

    Strain 2 %; E/E0 after 20 and 80 periods; momentum, the mean of a period and the largest (the swing of the stagger), over
    sqrt(2 E m).
    """
    header, cells = table(study, "test_levels_vibration", 80)
    study.table("Energy and momentum", header, cells)
    for line in cells:
        if line[2:5] == ["24", "default", "neo_hookean"]:
            study.expect(f"{line[0]}, ratio {line[1]}: E/E0 after 20 periods", float(line[5]), at_least=0.97)
    shown = [(f"{line[0]}, {line[3]}", float(line[5]), float(line[6])) for line in cells
             if line[1:3] == ["2", "24"] and line[4] == "neo_hookean" and line[3] in ("MUSL", "default")]
    study.plot("Energy kept", "periods", "E / E0", *(page.curve(name, [0, 20, 80], [1, *energies], "points") for name, *energies in shown))


def verify_block_in_space(study):
    """Energy of a block that vibrates across borders of levels in space

    A block of n x n/2 x n/2 coarse cells, half of it on the finer level, and a cube of n with a box in its middle; strain 2 %,
    E/E0 after 20 periods, n = 24 and 32.
    """
    _, cells = table(study, "test_levels_vibration", -20)
    energies = {(line[0], int(line[2])): float(line[5]) for line in cells}
    for (levels, n), energy in energies.items():
        goal = {"near": 1, "tolerance": 0.03} if n == 32 else {}
        (study.expect if goal else study.figure)(f"vibrating {levels}, n = {n}: E/E0 after 20 periods", energy, **goal)
    for one, levels in (("block in space, one level", "block in space, half"), ("cube, one level", "cube, box inside")):
        for n in (24, 32):
            study.expect(f"vibrating {levels}, n = {n}: energy against one level, 20 periods", abs(energies[levels, n] / energies[one, n] - 1), at_most=0.03)
    for levels, _, n, *_, left in cells:
        study.expect(f"vibrating {levels}, n = {n}: momentum less the stagger, of sqrt(2 E m)", float(left), at_most=1e-9)


def verify_waves(study):
    """Waves through the border of a finer level

    A packet of three wavelengths; the largest difference from the same run on one level, over the packet's amplitude.
    """
    _, cells = table(study, "test_levels_waves")
    parts = {}
    for wave, ratio, way, *figures in cells:
        pairs = [figure.split(":") for figure in figures if figure]
        parts[wave, ratio, way] = {int(length): float(values.split(",")[1]) for length, values in pairs}
    for way in ("into", "out of"):
        normal = parts["pressure, 0 degrees", "2", way]
        study.expect(f"waves, {way} the fine side: reflected, wavelength of 16 coarse cells", normal[16], at_most=0.01)
        study.expect(f"waves, {way} the fine side: reflected, wavelength of 32 coarse cells", normal[32], at_most=0.003)
    lengths = sorted({length for values in parts.values() for length in values})
    study.table("Reflected amplitude by wavelength in coarse cells", ["wave", "ratio", "fine side", *lengths],
                 [[*wave, *(f"{values[length]:.4f}" if length in values else "-" for length in lengths)] for wave, values in parts.items()])
    for way in ("into", "out of"):
        study.plot(f"Waves {way} the fine side", "wavelength (coarse cells)", "reflected / incoming amplitude",
                    *(page.curve(f"{wave}, ratio {ratio}", values, values.values(), "points")
                      for (wave, ratio, of), values in parts.items() if of == way), log=True)


def verify_checks(study):
    """Checks of the unit programs

    Patch test, the bar's period, bodies at rest on levels, points that change levels: what make test asserts too.
    """
    for program in ("test_patch", "test_vibration", "test_levels_rest", "test_levels_crossing", "test_levels_vibration"):
        check(study, program)
