"""Every verb of the command is reachable, and says what the command says."""

import json
import subprocess

import numpy as np
import pytest

import biss
from conftest import FORMAT, edges_of, run, simulated


def records_of(*words, status=0):
    return [json.loads(line) for line in run(*words, "--to", "jsonl", status=status).splitlines()]


def test_EveryVerb_HasItsHelp():
    listed = run("--help").split("Verbs:")[1].split("\n\n")[0].splitlines()
    verbs = [line.split()[0] for line in listed if line.startswith("  ") and line[2] != " "]
    assert len(verbs) > 15
    for verb in verbs:
        if verb in ("view", "help"):
            continue
        assert biss.run(verb, help=True).text == run(verb, "--help"), verb


def test_Reports_AreThoseOfTheCommand(damaged, noisy):
    assert biss.check(damaged, format=FORMAT) == records_of("check", damaged, "-f", FORMAT, status=1)
    assert biss.explain(damaged, format=FORMAT) == records_of("explain", damaged, "-f", FORMAT)
    assert biss.identify(noisy) == records_of("identify", noisy)
    assert biss.encoders() == records_of("encoders")
    assert biss.encoders("resolute-26") == records_of("encoders", "resolute-26")
    assert biss.plan("resolute-26") == records_of("plan", "-f", "resolute-26")
    assert biss.safety_analysis("fs-36-28") == records_of("safety", "analyse", "-f", "fs-36-28")
    assert biss.records("crc", "1234", format=FORMAT) == records_of("crc", "-f", FORMAT, "1234")
    assert biss.draw(damaged, cycle=3, format=FORMAT) == run("draw", damaged, "-f", FORMAT,
                                                             "--cycle", 3)
    assert biss.draw(damaged, cycle=3, svg=True).startswith("<svg")


def test_Arrays_TakeThePlaceOfFiles(damaged, folder):
    edges = biss.Capture.edges(*edges_of(damaged))
    assert biss.check(edges, format=FORMAT) == biss.check(damaged, format=FORMAT)
    assert biss.explain(edges, format=FORMAT)[0]["cause"] == \
        biss.explain(damaged, format=FORMAT)[0]["cause"]
    assert biss.draw(edges, cycle=3, format=FORMAT) == biss.draw(damaged, cycle=3, format=FORMAT)
    good = biss.simulate(FORMAT, cycles=200).capture
    assert biss.compare(good, edges, format=FORMAT) == \
        biss.compare(converted(good, folder), damaged, format=FORMAT)


def converted(capture, folder):
    path = folder / "good.csv"
    biss.run("convert", capture, output=path)
    return path


def test_Simulation_IsThatOfTheCommand(folder):
    truth = folder / "truth.csv"
    path = simulated(folder / "line.csv", "-f", "resolute-26", "--cycles", 300, "--seed", 9,
                     "--fault", "flip:0.1", "--fault", "cut@40,bit=5", "--truth", truth)
    made = biss.simulate("resolute-26", cycles=300, seed=9, fault=["flip:0.1", "cut@40,bit=5"])
    for mine, theirs in zip(made.capture.arrays, biss.Capture.load(path).arrays):
        assert np.array_equal(mine, theirs)
    lines = truth.read_text().splitlines()
    assert [",".join(row.values()) for row in made.truth] == lines[1:]
    with pytest.raises(biss.UsageError):
        biss.simulate("resolute-26", output="x.vcd")
    with pytest.raises(biss.UsageError, match="nothing"):
        biss.simulate("resolute-26", fault="nothing:0.1")


def test_SampleRate_IsAnOptionOfSimulate(folder):
    made, wanted = folder / "rate.bin", folder / "rate_wanted.bin"
    simulated(wanted, "-f", FORMAT, "--cycles", 5, "--sample-rate", "25MHz")
    biss.run("simulate", format=FORMAT, cycles=5, sample_rate="25MHz", output=made)
    assert made.read_bytes() == wanted.read_bytes()
    with pytest.raises(biss.UsageError, match="unknown option '--sample-rate'"):
        biss.records("plan", format=FORMAT, sample_rate="25MHz")


def test_SampleRateOfAFile_NamesRawRate(sampled, folder):
    path = folder / "file.bin"
    sampled.tofile(path)
    for read in (biss.decode, biss.check, biss.Capture.load):
        with pytest.raises(biss.UsageError, match="use raw_rate"):
            read(path, sample_rate=100_000_000)
    with pytest.raises(biss.UsageError, match="use raw_rate"):
        biss.draw(path, cycle=3, sample_rate=100_000_000)
    assert biss.decode(path, raw_rate="100MHz", ma="D0", slo="D1", format=FORMAT).rows == 500


def test_DrawingWithoutItsCycle_IsADataError(damaged):
    with pytest.raises(biss.DataError, match="no cycle 5000"):
        biss.draw(damaged, cycle=5000, format=FORMAT)


def test_FilesOfTheVerbs_AreWritten(damaged, folder):
    assert biss.run("decode", damaged, format=FORMAT, to="csv").text == \
        run("decode", damaged, "-f", FORMAT, "--to", "csv")
    biss.run("decode", damaged, format=FORMAT, to="hdf5", output=folder / "mine.h5")
    run("decode", damaged, "-f", FORMAT, "--to", "hdf5", "-o", folder / "theirs.h5")
    assert (folder / "mine.h5").read_bytes() == (folder / "theirs.h5").read_bytes()
    with pytest.raises(biss.CaptureError):
        biss.eds(folder / "nothing.hex")


def test_Status1_IsInTheResult(damaged):
    result = biss.run("decode", damaged, format=FORMAT, fail_on="any")
    assert result.status == 1 and result.output and "3000" in result.summary


def test_Messages_AreNotPrinted(damaged, folder):
    script = ("import biss, sys\n"
              "biss.decode(sys.argv[1]); biss.run('check', sys.argv[1])\n"
              "try: biss.decode('nothing.vcd')\nexcept biss.CaptureError: pass\n")
    done = subprocess.run(["/usr/bin/python3", "-c", script, str(damaged)], capture_output=True,
                          check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
