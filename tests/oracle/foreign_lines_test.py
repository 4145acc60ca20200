#!/usr/bin/env python3
"""The lines of foreign_lines.py before `biss decode`: are they what their truth says?

    foreign_lines_test.py BISS [COUNT]

A line on which nothing happened is read as sent: every frame that the capture has whole is `ok`, with
its bits and its position. Exit with 1 if one is not. Formats, truths and the comparison of formats are
checked too.
"""
import csv
import io
import pathlib
import random
import subprocess
import sys
import tempfile

import foreign_format
import foreign_lines
import judge_formats
from foreign_causes import CAUSES, PAIRS
from foreign_line import Line

FIRST_SEED = 700000


def formats():
    """Checksums against facts of the polynomials, and texts that come back as they were."""
    assert foreign_format.remainder(1 << 63 | 1, 64, 0x43) == 0  # the period of x^6 + x + 1 is 63
    assert all(foreign_format.remainder(1 << n | 1, n + 1, 0x43) for n in range(1, 63))
    text = "mt12,st14:gray,nE,W,lc6,crc16:0x11021:0x5A:plain+pos10:lsb,crc6:reversed;cds0"
    assert foreign_format.parse(text).text() == text, foreign_format.parse(text).text()


def differences_of_formats():
    """What a format of the answer is called, next to the true one."""
    true = foreign_format.parse("pos12,nE,nW,crc6")
    frames = [true.frame([{"pos": 100 + 3 * n, "nE": int(n % 9 != 0), "nW": 1}]) for n in range(60)]
    part = {"moved": ["000111111110" + "10"], "low": [{"nE": 0.11, "nW": 0.0}], "rank": [9], "smooth": True,
            "frames": ["0 " + "".join(map(str, frame)) for frame in frames]}
    for text, want in (("pos12,nE,nW,crc6", "right"), ("mt4,st8,nE,nW,crc6", "right"),
                       ("pad2,pos10,nE,nW,crc6", "right"), ("pos12,nE,pad1,crc6", "hidden"),
                       ("pos13,nE,crc6", "shown"), ("pos12,E,nW,crc6", "shown"),
                       ("pos12:gray,nE,nW,crc6", "shown"), ("pos12:lsb,nE,nW,crc6", "shown"),
                       ("pos15,crc5", "shown"), ("pos12,nE,nW,crc6:0x43:0x1", "shown")):
        right, shown, hidden = judge_formats.compare(text, true, part)
        got = "right" if right else "shown" if shown else "hidden"
        assert got == want and bool(hidden or shown) != right, (text, got, shown, hidden)


def truths():
    """Every cause can be drawn, and damages what it says; sent checksums are those of the format."""
    for number, causes in enumerate([[name] for name in CAUSES] + [list(pair) for pair in PAIRS]):
        seed = FIRST_SEED + number
        line = foreign_lines.draw("explain", seed, causes)
        truth = line.truth()
        assert truth["causes"] == causes, seed
        for cause in causes:
            few = len(truth["marks"][cause]) < 3
            assert few == (cause in ("healthy",)) or cause == "sampling_too_slow", (seed, cause)
    for seed in range(FIRST_SEED, FIRST_SEED + 20):
        for part in foreign_lines.draw("identify", seed).truth()["parts"]:
            true = foreign_format.parse(part["format"])
            right, shown, hidden = judge_formats.compare(part["format"], true, part)
            assert right, (seed, part["format"], shown, hidden)


def healthy_line(seed, wide):
    """A line of this seed without damage, whose format has a text."""
    for attempt in range(100):
        line = Line(random.Random(f"test {seed} {attempt}"), wide)
        line.causes = ["healthy"]
        CAUSES["healthy"](line)
        if any(channel.error == "cds" for channel in line.format.channels):
            continue  # has the usual checksum while CDS is 0
        line.run()
        if line.judge():
            return line
    raise AssertionError(f"seed {seed}: no line without damage")


def decode(biss, path, options):
    result = subprocess.run([biss, "decode", path, "--to", "csv", *options], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    return list(csv.DictReader(io.StringIO(result.stdout))), result.stderr


def differences(biss, line, path):
    """What `decode` reads otherwise than the line was made."""
    options = ["-f", line.format.text(), "--ma", line.names[0], "--slo", line.names[1]]
    rows, errors = decode(biss, path, options)
    begin = {round(float(row["time_ns"])): row for row in rows if row["time_ns"]}
    times = sorted(begin)
    found = []
    shift = line.delays[0] if line.probe_at_encoder else 0.0
    for request in line.inside():
        at = request.time - line.from_time + shift
        near = [t for t in times if abs(t - at) < line.period / 2]
        row = begin[near[0]] if near else None
        bits = "".join(map(str, request.answer.bits))
        # The checksum of the last frame would be in the next one.
        last = request is line.inside()[-1] and ":previous" in options[1]
        if last and row and row["status"] == "unchecked":
            continue
        # `raw` is START, CDS, the frame and STOP, as a number.
        if row is None or row["status"] != "ok":
            found.append((request.number, row and row["status"], errors.strip().split("\n")[-1]))
        elif bits not in f"{int(row['raw'], 16):b}":
            found.append((request.number, row["raw"], bits))
        else:
            value = request.answer.notes[0]
            first = line.format.channels[0]
            want = value["pos"]
            if not any(item.kind == "pos" for item in first.items):
                single = next(item.bits for item in first.items if item.kind == "st")
                want = value["mt"] << single | value["st"]
            if int(row["position"]) != want:
                found.append((request.number, row["position"], want))
    return found


def main():
    biss, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100
    formats()
    differences_of_formats()
    truths()
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "line.csv"
        for seed in range(FIRST_SEED, FIRST_SEED + count):
            line = healthy_line(seed, wide=seed % 2 == 1)
            foreign_lines.write_capture(line, path, random.Random(seed))
            found = differences(biss, line, path)
            if found:
                wrong += 1
                print(f"seed {seed}: {len(found)} of {len(line.inside())} differ: {found[:2]}"
                      f" {line.format.text()} {line.truth()['about']}")
    print(f"{count - wrong} of {count} lines are read as sent")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
