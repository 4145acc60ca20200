"""The command for comparison with the module: every test compares the two."""

import csv
import io
import os
import pathlib
import subprocess

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).parents[2]
COMMAND = os.environ.get("BISS", str(ROOT / "build" / "biss"))

FORMAT = "pos26,nE,nW,crc6"
FAULTS = ["flip:0.05", "cut:0.01", "glitch_ma:0.02", "no_answer:0.01", "late_start:0.01", "nE:0.02",
          "delay_step:0.01"]


def run(*words, status=0):
    """The command's standard output."""
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, check=False)
    assert done.returncode == status, done.stderr.decode()
    return done.stdout.decode()


def rows_of(*words):
    """The rows of `biss decode` as texts."""
    return list(csv.DictReader(io.StringIO(run("decode", *words, "--to", "csv"))))


def text_of(value):
    """A cell of a row as the command writes it in CSV."""
    if value is None:
        return ""
    if isinstance(value, float):
        return np.format_float_positional(value, trim="-")
    return str(value)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("captures")


def simulated(path, *options):
    run("simulate", "-o", path, *options)
    return path


@pytest.fixture(scope="session")
def damaged(folder):
    """A capture with every kind of row."""
    faults = [word for fault in FAULTS for word in ("--fault", fault)]
    return simulated(folder / "damaged.csv", "-f", FORMAT, "--cycles", 3000, "--seed", 5, *faults)


@pytest.fixture(scope="session")
def noisy(folder):
    """A capture whose format can be identified."""
    return simulated(folder / "noisy.csv", "-f", FORMAT, "--cycles", 3000, "--fault", "flip:0.05")


@pytest.fixture(scope="session")
def sampled(folder):
    """Raw samples at 100 MHz."""
    path = simulated(folder / "sampled.bin", "-f", FORMAT, "--cycles", 500, "--seed", 6,
                     "--sample-rate", "100MHz", "--fault", "flip:0.05")
    return np.fromfile(path, dtype=np.uint8)


def edges_of(path):
    """The edges of an event CSV: times in picoseconds, MA, SLO."""
    lines = path.read_text().splitlines()
    assert lines[0] == "time_ns,MA,SLO"
    cells = [line.split(",") for line in lines[1:]]
    times = [round(float(time) * 1000) for time, _, _ in cells]
    return (np.array(times, dtype=np.int64), np.array([int(c[1]) for c in cells], dtype=np.uint8),
            np.array([int(c[2]) for c in cells], dtype=np.uint8))
