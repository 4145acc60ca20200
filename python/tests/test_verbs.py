"""Every verb of the command is reachable, and has the same output as the command."""

import ast
import base64
import fcntl
import gzip
import json
import os
import pty
import re
import struct
import subprocess
import termios

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
        if verb in ("view", "read", "emulate", "watch", "help"):
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


def test_Evidence_HasTheTablesOfTheCommand(tmp_path):
    options = {"format": "pos14,nE,nW,crc4+pos10,nE,nW,lc6,crc8;cds0", "frames": 3000,
               "faults": 200, "cycles": 300}
    words = [word for name, value in options.items() for word in (f"--{name}", value)]
    run("safety", "evidence", *words, "-o", tmp_path / "theirs")
    result = biss.run("safety evidence", output=tmp_path / "mine", **options)
    assert result.status == 0 and result.output == b""
    names = sorted(path.name for path in (tmp_path / "theirs").iterdir())
    assert names == sorted(path.name for path in (tmp_path / "mine").iterdir())
    for name in ("analysis.txt", "analysis.jsonl", "campaign.csv", "sequences.csv", "line.csv",
                 "coverage.csv"):
        mine = (tmp_path / "mine" / name).read_bytes()
        assert mine and mine == (tmp_path / "theirs" / name).read_bytes(), name
    assert biss.run("safety evidence", check=tmp_path / "mine").status == 0


def embedded(page):
    """The data in a report about the whole capture."""
    text = re.search(r'id="biss-report">([^<]*)<', page.read_text())[1]
    return json.loads(gzip.decompress(base64.b64decode(text)))


@pytest.fixture(scope="module")
def large(folder):
    """A capture that is not in a report as a whole."""
    path = simulated(folder / "large.csv", "-f", "resolute-26", "--motion", "random", "--cycles",
                     15000, "--fault", "flip:0.002", "--seed", 3)
    assert path.stat().st_size > 16 << 20
    return path


def reported(tmp_path, capture, **options):
    page = tmp_path / "page.html"
    page.write_text('<p>a</p><script type="text/plain" id="biss-core">CORE</script>')
    made = tmp_path / "report.html"
    result = biss.run("report", capture, page=page, output=made, format="resolute-26", **options)
    assert result.status == 0
    return page, made


def test_ReportOfALargeCapture_HasTheAnswersOfTheCommand(large, tmp_path):
    page, made = reported(tmp_path, large)
    theirs = tmp_path / "theirs.html"
    run("report", large, "--page", page, "-f", "resolute-26", "-o", theirs)
    verbs = embedded(made)["verbs"]
    assert verbs == embedded(theirs)["verbs"]
    assert made.read_bytes() == theirs.read_bytes()
    assert '"format":"pos26,nE,nW,crc6;cds0"' in verbs["identify"]["out"]
    assert verbs["identify"]["err"].startswith("large.csv: 15000 request cycles")
    assert verbs["check renishaw"]["out"].startswith('{"rule":')


def test_ReportOfAnArray_IsNotThatOfAFileWithItsName(large, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "array").write_text("time_ns,MA,SLO\n0,1,1\n")
    _, made = reported(tmp_path, biss.Capture.load(large))
    assert embedded(made)["cycles"] == 15000
    biss.run("convert", biss.simulate("resolute-26", cycles=5).capture, output="array", to="csv")
    assert (tmp_path / "array").read_text().startswith("time_ns,MA,SLO\n")
    (tmp_path / "array").unlink()
    (tmp_path / "array").mkdir()
    _, made = reported(tmp_path, biss.Capture.content(large.read_bytes(), "large.csv"))
    answers = embedded(made)["verbs"]
    assert embedded(made)["cycles"] == 15000
    assert '"format":"pos26,nE,nW,crc6;cds0"' in answers["identify"]["out"]


def test_TextsOnAHostsTerminal_AreThoseOfAPipe(damaged):
    script = ("import biss, sys\n"
              f"print(repr([biss.run('explain', {str(damaged)!r}).text, "
              f"biss.draw({str(damaged)!r}, cycle=3)]), file=sys.stderr)\n")
    main, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 50, 0, 0))
    done = subprocess.run(["/usr/bin/python3", "-c", script], stdout=terminal, check=True,
                          stderr=subprocess.PIPE)
    os.close(main)
    os.close(terminal)
    explained, drawn = ast.literal_eval(done.stderr.decode())
    assert explained == run("explain", damaged)
    assert drawn == run("draw", damaged, "--cycle", 3)


def test_NameThatSteersATerminal_IsHarmlessInAMessage(tmp_path):
    path = tmp_path / "a\x1b[2J\u202e.vcd"
    with pytest.raises(biss.CaptureError) as failed:
        biss.decode(path)
    shown = str(failed.value)
    assert "\x1b" not in shown and "\u202e" not in shown and "a?[2J\ufffd.vcd" in shown
