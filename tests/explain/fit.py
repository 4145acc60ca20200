#!/usr/bin/env python3
"""Fit how bits become likelihoods, and print explain/diagnose.cpp with the numbers.

    tests/oracle/judge.py explain --biss build/biss --seed 1 --count 2000 --results results.jsonl
    tests/explain/fit.py explain/diagnose.cpp results.jsonl > new.cpp

The command prints likelihoods only. With the numbers that it was built with, they give back the bits
by which each cause is behind the first one; what it does not list counts as far behind. Fit on seeds
below 10000 only. For a good view of the bits, build with scale 2 and power 1 before.
"""
import json
import math
import re
import sys


def read_numbers(path):
    text = open(path, encoding="utf-8").read()
    return [float(re.search(rf"weight_{name} = ([\d.]+);", text).group(1)) for name in ("scale", "power")]


def names():
    text = open(re.sub(r"diagnose\.cpp$", "cause.hpp", sys.argv[1]), encoding="utf-8").read()
    return re.findall(r"^  (\w+),$", re.search(r"enum class Cause.*?};", text, re.S).group(0), re.M)


def cases(paths, scale, power, order):
    """[(bits behind by cause, accepted causes)] of each run."""
    out = []
    for path in paths:
        for line in open(path, encoding="utf-8"):
            truth = json.loads(line)
            for run in truth["runs"]:
                accept = truth["accept"][run["mode"]]
                if not accept or not run["causes"]:
                    continue
                weights = {c: l for c, l in run["causes"] if l > 0}
                top = max(weights.values())
                behind = {c: scale * ((top / w) ** (1 / power) - 1) for c, w in weights.items()}
                out.append((behind, {order.index(c) for c in accept}))
    return [({order.index(c): b for c, b in behind.items()}, accept) for behind, accept in out]


def loss(data, scale, power, causes):
    """Bits of surprise about the true causes; the causes not listed share what is left."""
    total = 0.0
    for behind, accept in data:
        weights = {c: (1 + b / scale) ** -power for c, b in behind.items()}
        # A cause that was not listed is at least as far behind as the last one.
        far = max(behind.values())
        rest = (causes - len(weights)) * (1 + (2 * far + 20) / scale) ** -power
        right = sum(w for c, w in weights.items() if c in accept)
        if not any(c in weights for c in accept):
            right = rest / max(1, causes - len(weights))
        total -= math.log2(max(right / (sum(weights.values()) + rest), 1e-9))
    return total / len(data)


def main():
    order = names()
    data = cases(sys.argv[2:], *read_numbers(sys.argv[1]), order)
    scale, power = 4.0, 1.5
    best = loss(data, scale, power, len(order))
    for step in (2.0, 1.4, 1.15):
        improved = True
        while improved:
            improved = False
            for trial in ((scale * step, power), (scale / step, power), (scale, power * step), (scale, power / step)):
                value = loss(data, *trial, len(order))
                if value < best - 1e-4:
                    best, (scale, power), improved = value, trial, True
    text = open(sys.argv[1], encoding="utf-8").read()
    text = re.sub(r"weight_scale = [\d.]+;", f"weight_scale = {scale:.2f};", text)
    text = re.sub(r"weight_power = [\d.]+;", f"weight_power = {power:.2f};", text)
    print(text, end="")
    print(f"{len(data)} runs, {best:.3f} bits a run", file=sys.stderr)


main()
