#!/usr/bin/env python3
"""Runs the studies that take longer than a test should: the functions verify_* in tests/cases. Same usage as run.py."""
import sys

import run

if __name__ == "__main__":
    sys.exit(run.main(sys.argv[1:], prefix="verify_"))
