"""The example runs, and the types of the package are right."""

import pathlib
import subprocess

ROOT = pathlib.Path(__file__).parents[2]


def test_Example_Runs(folder):
    done = subprocess.run(["/usr/bin/python3", ROOT / "examples/python/bench_report.py", folder],
                          capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    assert "positions" in done.stdout.decode()


def test_Types_AreConsistent():
    done = subprocess.run(["/usr/bin/mypy", "--strict", "--cache-dir=/dev/null",
                           "--python-executable=/usr/bin/python3", "-p", "biss"],
                          cwd=ROOT / "python", capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode()
