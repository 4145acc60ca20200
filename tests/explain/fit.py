#!/usr/bin/env python3
"""Fit how bits become likelihoods, and print explain/fitted.hpp.

    tests/oracle/judge.py explain --biss build/biss --seed 1 --count 2000 --results results.jsonl
    tests/explain/fit.py explain/fitted.hpp results.jsonl > new.hpp

The command prints likelihoods only. With the values of the header that it was built with, they give
back the bits by which each cause is behind the first one; what it does not list counts as far
behind. Fit on seeds below 10000 only. For a good view of the bits, build with scale 2 and power 1
(and all priors 1) before.
"""
import json
import math
import re
import sys


def read_header(path):
    text = open(path, encoding="utf-8").read()
    number = lambda name: float(re.search(rf"{name} = ([\d.]+);", text).group(1))
    block = re.search(r"prior\{(.*?)\}", text, re.S).group(1)
    return number("scale"), number("power"), [float(part) for part in block.split(",")]


def names():
    text = open(re.sub(r"fitted\.hpp$", "cause.hpp", sys.argv[1]), encoding="utf-8").read()
    return re.findall(r"^  (\w+),$", re.search(r"enum class Cause.*?};", text, re.S).group(0), re.M)


def cases(paths, scale, power, prior, order):
    """[(bits behind by cause, accepted causes)] of each run."""
    out = []
    for path in paths:
        for line in open(path, encoding="utf-8"):
            truth = json.loads(line)
            for run in truth["runs"]:
                accept = truth["accept"][run["mode"]]
                if not accept or not run["causes"]:
                    continue
                weights = {c: l / prior[order.index(c)] for c, l in run["causes"] if l > 0}
                top = max(weights.values())
                behind = {c: scale * ((top / w) ** (1 / power) - 1) for c, w in weights.items()}
                out.append((behind, {order.index(c) for c in accept}))
    return [({order.index(c): b for c, b in behind.items()}, accept) for behind, accept in out]


def loss(data, scale, power, prior):
    """Bits of surprise about the true causes; the causes not listed share what is left."""
    total = 0.0
    for behind, accept in data:
        weights = {c: prior[c] * (1 + b / scale) ** -power for c, b in behind.items()}
        # A cause that was not listed is at least as far behind as the last one.
        far = max(behind.values())
        rest = (len(prior) - len(weights)) * (1 + (2 * far + 20) / scale) ** -power
        right = sum(w for c, w in weights.items() if c in accept)
        if not any(c in weights for c in accept):
            right = rest / max(1, len(prior) - len(weights))
        total -= math.log2(max(right / (sum(weights.values()) + rest), 1e-9))
    return total / len(data)


def main():
    order = names()
    data = cases(sys.argv[2:], *read_header(sys.argv[1]), order)
    scale, power, prior = 4.0, 1.5, [1.0] * len(order)
    best = loss(data, scale, power, prior)
    for step in (2.0, 1.4, 1.15):
        improved = True
        while improved:
            improved = False
            for at in range(-2, len(prior)):
                for factor in (step, 1 / step):
                    trial = [scale, power, list(prior)]
                    if at < 0:
                        trial[at + 2] *= factor
                    else:
                        trial[2][at] = min(max(trial[2][at] * factor, 0.1), 10.0)
                    value = loss(data, *trial)
                    if value < best - 1e-4:
                        best, (scale, power, prior), improved = value, trial, True
    rows = ",\n".join("    " + ", ".join(f"{p:.2f}" for p in prior[i:i + 8])
                      for i in range(0, len(prior), 8))
    head = open(sys.argv[1], encoding="utf-8").read()
    head = re.sub(r"scale = [\d.]+;", f"scale = {scale:.2f};", head)
    head = re.sub(r"power = [\d.]+;", f"power = {power:.2f};", head)
    head = re.sub(r"prior\{.*?\}", f"prior{{\n{rows}}}", head, flags=re.S)
    print(head, end="")
    print(f"{len(data)} runs, {best:.3f} bits a run", file=sys.stderr)


main()
