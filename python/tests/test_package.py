"""The example runs, and the types of the package are right."""

import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).parents[2]


def test_Example_Runs(folder):
    done = subprocess.run(["/usr/bin/python3", ROOT / "examples/python/bench_report.py", folder],
                          capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    # The simulated encoder moves slowly, and over 0.
    step = re.search(r"positions, largest step (\d+) counts", done.stdout.decode())
    assert step and int(step[1]) < 1 << 20


def test_Types_AreConsistent():
    done = subprocess.run(["/usr/bin/mypy", "--strict", "--cache-dir=/dev/null",
                           "--python-executable=/usr/bin/python3", "-p", "biss"],
                          cwd=ROOT / "python", capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode()
