#!/usr/bin/env python3
"""Make lines of BiSS C, and of other protocols, that the project's simulator did not make.

    foreign_lines.py --seed S --count N --kind explain|identify|protocols --out FOLDER

Line i has the seed S + i and does not depend on the other lines: --seed 17 --count 1 makes line 17
again. Tune only on seeds below 10000; those from 100000 on are for reports. FOLDER gets

  SEED.csv      the changes of two lines (event CSV)
  truth.jsonl   an object a line:
    seed, kind, file, causes
    format      what the encoder sent, in the grammar of -f; null if the grammar has no word for it
    without     options of a run without a format; null if this line says nothing without one
    with        options of a run with -f; null if there is no format to give
    accept      causes that may be first in a run: {"with": [...], "without": [...]}
    requests    request cycles that the capture has whole
    damaged     their numbers (from 0) that the causes damaged; ill: 3 of them or more, or 1 in 100
    marks       the same for each cause
    answered    share of the requests that have ACK and START
    parts       for each format that the encoder sent, in order of time
      format    as above
      from, to  the first and the last of the request cycles
      moved     a string a channel, in line order: 1 for a data bit that changed
      low       of each flag, the share of frames in which it was 0: [{"nE": 0.0, "nW": 0.3}]
      rank      independent frames, of each channel
      smooth    whether the position moves so little that the order of its bits shows
      frames    up to 400 frames as sent: CDS, a blank, and the bits of data and CRC
    about       how the line was drawn, for people

Only the standard library of Python is used. The same seed gives the same line.
"""
import argparse
import json
import math
import pathlib
import random

from foreign_causes import CAUSES, PAIRS, WEIGHTS, change_length
from foreign_encoder import Flag
from foreign_line import Line
from foreign_protocols import PROTOCOLS

MODES = ("with", "without")


def draw_causes(luck):
    """Nothing wrong, one cause, or two at once."""
    if luck.random() < 0.08:
        return list(luck.choice(PAIRS))
    names = list(CAUSES) + ["not_biss"]
    return [luck.choices(names, [WEIGHTS.get(name, 1) for name in names])[0]]


def explain_line(luck, causes):
    """A line with these causes, or None if nothing happened on it."""
    if causes == ["not_biss"]:
        return protocol_line(luck, causes)
    line = Line(luck)
    line.causes = causes
    for cause in sorted(causes, key=list(CAUSES).index):
        CAUSES[cause](line)
    line.run()
    return line if line.judge() else None


def identify_line(luck, causes):
    """A readable line, with up to a tenth of the frames damaged."""
    line = Line(luck, wide=True)
    line.causes = ["healthy"]
    kinds = Flag.KINDS
    line.flag_kinds = {"nE": luck.choice(kinds) if luck.random() < 0.45 else "none",
                       "nW": luck.choice(kinds) if luck.random() < 0.45 else "none"}
    damage = luck.choice((None, None, "noise_on_slo", "noise_on_ma"))
    if damage:
        CAUSES[damage](line)
        line.probe_at_encoder = False
    if luck.random() < 0.04:
        change_length(line)
    elif luck.random() < 0.05:  # no clock for STOP
        line.extra, line.rhythm, line.byte_clocks = -1, "steady", False
        line.control, line.cdm = False, {}
    if line.samples and luck.random() < 0.1:
        line.samples = luck.uniform(3.5, 5.5)
    line.run()
    if not line.shows_error() or not line.readable():
        return None
    whole = line.inside()
    bad = sum(line.read(request) != "good" for request in whole)
    line.marks = {}
    line.name()
    return line if len(whole) > 20 and bad <= 0.1 * len(whole) else None


class Protocol:
    """A line of another protocol, with the face of Line that the truth needs."""

    def __init__(self, luck, name):
        self.causes, self.name = ["not_biss"], name
        self.captured = [list(pair) for pair in PROTOCOLS[name](luck)]
        self.from_time, self.step = 0.0, None
        if luck.random() < 0.5:  # sampled, at least eight times as fast as the shortest level
            shortest = min(b - a for _, times in self.captured for a, b in zip(times, times[1:]))
            self.step = max(shortest, 4.0) / luck.uniform(4, 20)
            phase = luck.uniform(0, self.step)
            for pair in self.captured:
                pair[1] = [math.ceil((t - phase) / self.step) * self.step for t in pair[1]]
        if luck.random() < 0.2:
            for pair in self.captured:
                pair[0] ^= 1
        self.to_time = max(times[-1] for _, times in self.captured) + luck.uniform(1e3, 1e5)
        self.names = luck.choice((["MA", "SLO"], ["D0", "D1"], ["D4", "D3"], ["A", "B"]))
        self.columns = luck.choice(([0, 1], [1, 0]))
        self.luck = luck

    def truth(self):
        given = self.luck.choice(("pos26,nE,nW,crc6", "pos18,nE,nW,crc6", "mt12,st13,nE,nW,crc6"))
        accept = ["not_biss"] + (["noise_on_ma", "noise_on_slo"] if self.name == "noise" else [])
        return {"causes": self.causes, "format": None, "without": [], "with": ["-f", given],
                "accept": {mode: accept for mode in MODES}, "requests": 0, "damaged": [],
                "ill": True, "marks": {}, "answered": 0.0, "parts": [], "about": {"protocol": self.name}}


def protocol_line(luck, causes):
    return Protocol(luck, luck.choice(list(PROTOCOLS)))


KINDS = {"explain": explain_line, "identify": identify_line, "protocols": protocol_line}


def draw(kind, seed, causes=None):
    """The line of this seed; lines on which nothing happened are drawn again."""
    causes = causes or draw_causes(random.Random(f"{kind} {seed}"))
    for attempt in range(100):
        line = KINDS[kind](random.Random(f"{kind} {seed} {attempt}"), causes)
        if line:
            line.attempt = attempt
            return line
    raise RuntimeError(f"{kind} {seed}: nothing happens with {causes}")


def write_capture(line, path, luck):
    """The changes as event CSV, with a header of one of several programs."""
    head, scale, places = luck.choice((("time_ns", 1.0, 3), ("Time [s]", 1e-9, 12), ("time_us", 1e-3, 6),
                                       ("time_ps", 1e3, 0)))
    first = [line.captured[index][0] for index in line.columns]
    changes = sorted((time, column) for column, index in enumerate(line.columns)
                     for time in line.captured[index][1])
    with open(path, "w", encoding="utf-8") as out:
        out.write(",".join([head] + [line.names[index] for index in line.columns]) + "\n")
        levels = list(first)
        out.write(f"{0:.{places}f},{levels[0]},{levels[1]}\n")
        at = 0
        while at < len(changes):
            time = changes[at][0]
            while at < len(changes) and changes[at][0] == time:
                levels[changes[at][1]] ^= 1
                at += 1
            out.write(f"{time * scale:.{places}f},{levels[0]},{levels[1]}\n")
        end = max(line.to_time - line.from_time, changes[-1][0] if changes else 0.0)
        out.write(f"{end * scale:.{places}f},{levels[0]},{levels[1]}\n")


def make(kind, seed, folder):
    """Writes the capture of a seed; returns its truth."""
    line = draw(kind, seed)
    name = f"{seed}.csv"
    write_capture(line, folder / name, random.Random(f"file {kind} {seed}"))
    return {"seed": seed, "kind": kind, "file": name, **line.truth(), "attempt": line.attempt}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, help="seed of the first line")
    parser.add_argument("--count", type=int, default=10, help="number of lines")
    parser.add_argument("--kind", choices=KINDS, default="explain")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with open(options.out / "truth.jsonl", "w", encoding="utf-8") as out:
        for seed in range(options.seed, options.seed + options.count):
            out.write(json.dumps(make(options.kind, seed, options.out)) + "\n")


if __name__ == "__main__":
    main()
