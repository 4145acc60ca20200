#!/usr/bin/env python3
"""Lines of foreign_lines.py of which `biss explain` or `biss identify` once said something wrong, by kind.

    lines_that_went_wrong.py BISS

With one cause, it is the first one; of two, both are among the first three. A format that is sure
(0.9) is right. Exit with 1 if not.
"""
import multiprocessing
import pathlib
import sys
import tempfile

import foreign_lines
import judge

# What is on the lines, and their seeds: with the format and without it, or one of both.
KINDS = {
    "EnDat whose CRC is not inverted and whose recovery time varies": {"with": (6348, 6531, 6692, 6770),
                                                                     "without": (6531, 6692, 6770)},
    "I2C behind an inverter": {"with": (6533,), "without": (6533,)},
    "asynchronous words in groups are no request with pauses": {"with": (6255, 6715), "without": (6255, 6715)},
    "two open inputs": {"with": (6046, 6381, 6664), "without": (6046, 6381, 6664)},
    "a second format that hardly moves": {"with": (6593, 6764), "without": (6593, 6764)},
    "single positions that jump": {"without": (6273, 6301, 6323, 6378)},
    "a checksum that no rule gives": {"with": (6068,)},
    "a format that is a bit too short, and positions that look likely by it": {"with": (6369, 6438, 6638)},
    "frames that the master cuts while the axis rests": {"with": (6123, 6282, 6699, 6756), "without": (6123,)},
    "errors in frames that the master cuts": {"with": (6094, 6723, 6724)},
    "positions that go round within their field": {"with": (6114, 8135, 8277), "without": (6114, 8135, 8277)},
    "a position at constant speed that counts": {"without": (8175, 8700)},
    "doubled clocks while the axis moves fast": {"with": (8215,), "without": (8215,)},
    "short frames over a long cable, and reduced frames": {"with": (8189, 8744), "without": (8189, 8744)},
    "frames that are a bit shorter for a while": {"with": (8182, 8738), "without": (8182, 8738)},
    "two causes, of which the second explains few requests": {"with": (6547, 6562), "without": (6562, 6734)},
}
FORMATS = {
    "turns in Gray code, of which few were seen": (500119, 501561, 501766, 501904),
    "the lowest bit of a position beside a single flag": (502216, 502560, 503601, 4841, 5101, 700509, 703267,
                                                            703624, 803804),
    "a single flag before the position": (700646, 701849),
    "a change of length beside a damaged frame": (501528,),
}


def judge_line(task):
    biss, kind, mode, seed, folder = task
    folder = pathlib.Path(folder) / f"{mode}-{seed}"
    folder.mkdir()
    if mode == "format":
        truth = foreign_lines.make("identify", seed, folder)
        sure = [run for run in judge.identify_runs(biss, truth, folder / truth["file"])
                if run["candidates"] and run["candidates"][0][1] >= 0.9]
        wrong = [f"{run['candidates'][0]}, not {run['true']}" for run in sure if not run["differences"][0][0]]
        return f"{kind}: seed {seed}: {'; '.join(wrong)}" if wrong else None
    truth = foreign_lines.make("explain", seed, folder)
    other = "without" if mode == "with" else "with"
    truth[other] = None
    run, = judge.explain_runs(biss, truth, folder / truth["file"])
    causes, true = [cause for cause, _ in run["causes"]], set(truth["accept"][mode])
    both = len(truth["causes"]) > 1
    right = true <= set(causes[:3]) if both else bool(causes) and causes[0] in true
    return None if right else f"{kind}: seed {seed} {mode} the format: {causes}, not {sorted(true)}"


def main():
    biss = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder, multiprocessing.Pool(2) as pool:
        tasks = [(biss, kind, mode, seed, folder) for kind, modes in KINDS.items()
                 for mode, seeds in modes.items() for seed in seeds]
        tasks += [(biss, kind, "format", seed, folder) for kind, seeds in FORMATS.items() for seed in seeds]
        wrong = [text for text in pool.map(judge_line, tasks) if text]
    print("\n".join(wrong + [f"{len(tasks)} lines of {len(KINDS) + len(FORMATS)} kinds, {len(wrong)} of them wrong"]))
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
