"""Orders of convergence of the manufactured solution on grids finer than a test has time for."""
import math
import subprocess

import harness


def table(largest):
    """{variant: {n: (max error, rms error)}} as bin/test_manufactured prints it."""
    done = subprocess.run([str(harness.ROOT / "bin" / "test_manufactured"), "table", str(largest)], capture_output=True,
                          text=True, env=harness.ENVIRONMENT, check=True)
    print(done.stdout)
    errors = {}
    for line in done.stdout.splitlines()[2:]:
        variant, n, largest_error, _, rms, _ = [word.strip() for word in line.strip("|").split("|")]
        errors.setdefault(variant, {})[int(n)] = (float(largest_error), float(rms))
    return errors


def order(of, kind):
    """Mean order from n = 16 to 128 of the max (0) or rms (1) error."""
    return math.log2(of[16][kind] / of[128][kind]) / 3


def verify_manufactured(report):
    errors = table(128)
    for variant in ("cpGIMP USL", "cpGIMP MUSL XPIC(2) 10 %", "cpGIMP default"):
        report.expect(f"manufactured, {variant}: order of the rms error, n = 16..128", order(errors[variant], 1), at_least=1.8)
        report.note(f"manufactured, {variant}: order of the max error, n = 16..128: {order(errors[variant], 0):.2f}", True)
    original = errors["original MPM USL"]
    report.note("manufactured, original MPM does not converge", not original[128][1] < 0.5 * original[16][1])
