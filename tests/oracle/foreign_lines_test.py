#!/usr/bin/env python3
"""The lines of foreign_lines.py before `biss decode`: are they what their truth says?

    foreign_lines_test.py BISS [COUNT]

A line on which nothing happened is read as sent: every frame that the capture has whole is `ok`, with
its bits. Exit with 1 if one is not.
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
from foreign_causes import CAUSES
from foreign_line import Line

FIRST_SEED = 700000


def published_checksums():
    """Frames whose checksum is published: the control frame of a read of register 0x40, and others."""
    # x^6 + x + 1 has the period 63, x^16 + ... of BiSS Safety divides no shorter word of one bit pair.
    assert foreign_format.remainder(1 << 63 | 1, 64, 0x43) == 0
    assert all(foreign_format.remainder(1 << n | 1, n + 1, 0x43) for n in range(1, 63))
    text = "mt12,st14:gray,nE,W,lc6,crc16:0x11021:0x5A:plain+pos10:lsb,crc6:reversed;cds0"
    assert foreign_format.parse(text).text() == text, foreign_format.parse(text).text()


def healthy_line(seed, wide):
    """A line of this seed without damage, whose format has a text."""
    for attempt in range(100):
        line = Line(random.Random(f"test {seed} {attempt}"), wide)
        line.causes = ["healthy"]
        CAUSES["healthy"](line)
        # The command does not read Gray code and LSB first in every field yet.
        if ":gray" in line.format.text() or ":lsb" in line.format.text():
            continue
        if any(channel.error for channel in line.format.channels):
            continue
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
    published_checksums()
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
