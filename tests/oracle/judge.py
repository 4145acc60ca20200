#!/usr/bin/env python3
"""Judge what the command says of lines that it was not tuned on.

    judge.py explain   --biss build/biss --seed 100000 --count 4000
    judge.py identify  --biss build/biss --seed 100000 --count 4000
    judge.py protocols --biss build/biss --seed 100000 --count 500
    judge.py explain --simulate …     lines of `biss simulate` with all its faults

The lines are those of foreign_lines.py: `foreign_lines.py --kind explain --seed S --count 1` makes one
of them again. Tables are printed as Markdown. --results writes an object a run, to look at the runs
that are wrong. --limits fails if a limit of the project is missed.
"""
import argparse
import collections
import json
import multiprocessing
import pathlib
import shutil
import subprocess
import sys
import tempfile

import foreign_format
import foreign_lines
import judge_formats
import simulated_lines

FEW = 400  # answers that a bin needs


def rows_of(biss, verb, path, options):
    """The rows that a verb prints, and its message if there are none."""
    result = subprocess.run([biss, verb, str(path), "--to", "jsonl", *options], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    rows = [json.loads(line) for line in result.stdout.splitlines()]
    return rows, "" if rows else result.stderr.strip().split("\n")[-1]


def explain_runs(biss, truth, path):
    runs = []
    for mode in foreign_lines.MODES:
        if truth[mode] is None:
            continue
        rows, message = rows_of(biss, "explain", path, truth[mode])
        runs.append({"mode": mode, "options": truth[mode], "message": message,
                     "causes": [[row["cause"], row["likelihood"]] for row in rows]})
    return runs


def candidates(row):
    """[(format, odds)] of a row of identify, the likeliest first."""
    found = [(row["format"], row["confidence"] or 0.0)] if row.get("format") else []
    others = row.get("alternatives") or []
    if isinstance(others, str):
        others = [{"format": text, "odds": None} for text in others.split(" | ")]
    found += [(other["format"], other["odds"]) for other in others if other["format"] != row.get("format")]
    return found


def row_of_part(rows, part, last):
    """The row for this part of the capture; with one row for all, only the longest part has one."""
    if len(rows) == 1 or "from_cycle" not in rows[0]:
        return rows[0] if rows and part["to"] - part["from"] >= last / 2 else None
    middle = (part["from"] + part["to"]) / 2 / max(1, last)
    longest = max(row["to_cycle"] for row in rows)
    near = [row for row in rows if row["from_cycle"] <= middle * longest <= row["to_cycle"]]
    return near[0] if near else None


def identify_runs(biss, truth, path):
    rows, message = rows_of(biss, "identify", path, truth["without"])
    runs = []
    parts = truth["parts"] or [{"format": None, "from": 0, "to": 0}]
    for part in parts:
        run = {"message": message, "candidates": [], "differences": [], "true": part["format"]}
        row = row_of_part(rows, part, parts[-1]["to"])
        if row:
            run["protocol"] = [row.get("protocol"), row.get("protocol_confidence") or 0.0]
            run["candidates"] = candidates(row)
            if part["format"]:
                true = foreign_format.parse(part["format"])
                run["differences"] = [judge_formats.compare(text, true, part)
                                      for text, _ in run["candidates"][:5]]
        runs.append(run)
    return runs


def judge_line(task):
    """Makes the line of a seed, runs the command on it, and removes it."""
    verb, source, biss, seed, folder = task
    folder = pathlib.Path(folder) / str(seed)
    folder.mkdir()
    try:
        if source == "simulate":
            truth = simulated_lines.make(biss, verb, seed, folder)
        else:
            truth = foreign_lines.make(verb, seed, folder)
        run = explain_runs if verb == "explain" else identify_runs
        truth["runs"] = run(biss, truth, folder / truth["file"])
    finally:
        shutil.rmtree(folder)
    for part in truth["parts"]:
        part.pop("frames", None)
    return truth


def percent(part, whole):
    return f"{100 * part / whole:.1f} %" if whole else "-"


def reliability(answers):
    """[(stated, whether true)] in bins of 0.1; returns the rows and the largest difference."""
    bins = collections.defaultdict(list)
    for stated, true in answers:
        bins[min(9, int(stated * 10))].append((stated, true))
    rows, worst = [], 0.0
    for number in sorted(bins):
        here = bins[number]
        stated = sum(s for s, _ in here) / len(here)
        observed = sum(t for _, t in here) / len(here)
        rows.append((f"{number / 10:.1f} to {(number + 1) / 10:.1f}", len(here), f"{stated:.3f}",
                     f"{observed:.3f}"))
        if len(here) >= FEW:
            worst = max(worst, abs(stated - observed))
    return rows, worst


def table(head, rows):
    print("| " + " | ".join(head) + " |")
    print("|---" + "".join("|---" if name == "taken for" else "|---:" for name in head[1:]) + "|")
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |")
    print()


class Limits:
    """The figures that must be reached."""

    def __init__(self):
        self.missed = []

    def check(self, text, value, least=None, most=None):
        if (least is not None and value < least) or (most is not None and value > most):
            self.missed.append(f"{text}: {value:.4g}, not {'at least' if least is not None else 'at most'} "
                               f"{least if least is not None else most}")


def report_explain(lines, limits, simulated):
    runs = [(line, run) for line in lines for run in line["runs"]]
    rows, answers, every = [], [], []
    for mode in foreign_lines.MODES:
        one = [(l, r) for l, r in runs if r["mode"] == mode]
        double = [(l, r) for l, r in one if len(l["causes"]) == 2 == len(l["accept"][mode])]
        hit = lambda pairs, n: sum(any(c in l["accept"][mode] for c, _ in r["causes"][:n]) for l, r in pairs)
        both = sum(set(l["causes"]) <= {c for c, _ in r["causes"][:3]} for l, r in double)
        rows.append((mode + " -f", len(one), percent(hit(one, 1), len(one)), percent(hit(one, 2), len(one)),
                     len(double), percent(both, len(double))))
        if one:
            limits.check(f"first {mode} format", hit(one, 1) / len(one),
                         0.92 if simulated else 0.94 if mode == "with" else 0.90)
            if not simulated:
                limits.check(f"among two {mode} format", hit(one, 2) / len(one),
                             0.98 if mode == "with" else 0.97)
        if double and not simulated:
            limits.check(f"both causes among three {mode} format", both / len(double), 0.70)
    table(("run", "lines", "first right", "among two", "two causes", "both among three"), rows)

    first = lambda run: run["causes"][0] if run["causes"] else ["none", 0.0]
    well = [(l, r) for l, r in runs if l["causes"] == ["healthy"]]
    ill = [(l, r) for l, r in runs if l["ill"] and "healthy" not in l["accept"][r["mode"]]]
    kept = sum(first(r)[0] == "healthy" for _, r in well)
    missed = [(l, r) for l, r in ill if first(r)[0] == "healthy" and first(r)[1] > 0.5]
    slow = [(l, r) for l, r in runs if l["causes"] == ["sampling_too_slow"]]
    named = sum(any(c == "sampling_too_slow" for c, _ in r["causes"][:2]) for _, r in slow)
    refused = [(l, r) for l, r in runs if l["answered"] > 0.5 and first(r)[0] == "not_biss"]
    certain = [(l, r) for l, r in runs
               if first(r)[1] > 0.8 and first(r)[0] not in l["accept"][r["mode"]]]
    table(("what", "runs", "of"), [
        ("healthy lines called healthy", kept, len(well)),
        ("ill lines called healthy above 0.5", len(missed), len(ill)),
        ("fewer than 5 samples a period: named among two", named, len(slow)),
        ("`not_biss` first, with ACK and START in most requests", len(refused),
         sum(l["answered"] > 0.5 for l, _ in runs)),
        ("wrong above 0.8", len(certain), len(runs))])
    if well:
        limits.check("healthy kept", kept / len(well), 0.98)
    if ill:
        limits.check("ill called healthy", len(missed) / len(ill), most=0.02)
    limits.check("not_biss with ACK and START", len(refused), most=0)
    for title, group in (("ill called healthy", missed), ("not_biss", refused)):
        if group:
            print(f"{title}: " + ", ".join(f"{l['seed']} {r['mode']}" for l, r in group[:60]),
                  file=sys.stderr)

    rows = []
    for cause in sorted({l["causes"][0] for l, _ in runs if len(l["causes"]) == 1}):
        mine = [(l, r) for l, r in runs if l["causes"] == [cause]]
        right = sum(first(r)[0] in l["accept"][r["mode"]] for l, r in mine)
        others = collections.Counter(first(r)[0] for l, r in mine if first(r)[0] not in l["accept"][r["mode"]])
        two = sum(any(c in l["accept"][r["mode"]] for c, _ in r["causes"][:2]) for l, r in mine)
        rows.append((f"`{cause}`", len(mine), right, two,
                     ", ".join(f"`{name}` {count}" for name, count in others.most_common())))
    table(("true cause", "runs", "first", "among two", "taken for"), rows)
    for line, run in runs:
        for index, (cause, likelihood) in enumerate(run["causes"]):
            true = cause in line["accept"][run["mode"]]
            if index == 0:
                answers.append((likelihood, true))
            every.append((likelihood, true))
    bins, worst = reliability(answers)
    table(("likelihood of the first", "answers", "stated", "right"), bins)
    limits.check("reliability of explain", worst, most=0.07)
    bins, _ = reliability(every)
    table(("likelihood of any cause", "answers", "stated", "right"), bins)


def report_identify(lines, limits):
    runs = [(line, run) for line in lines for run in line["runs"]]
    sure, answers, shown, hidden, found, first_right = [], [], [], [], 0, 0
    for line, run in runs:
        right = [d[0] for d in run["differences"]]
        found += any(right)
        first_right += bool(right and right[0])
        if not run["candidates"]:
            answers.append((0.0, False))
            continue
        odds = run["candidates"][0][1] or 0.0
        answers.append((odds, right[0]))
        if odds < 0.9:
            continue
        sure.append(line)
        if run["differences"][0][1]:
            shown.append((line, run))
        elif run["differences"][0][2]:
            hidden.append((line, run))
    table(("what", "lines", "share"), [
        ("lines of BiSS C", len(runs), ""),
        ("first right", first_right, percent(first_right, len(runs))),
        ("right among the first five", found, percent(found, len(runs))),
        ("sure (0.9)", len(sure), percent(len(sure), len(runs))),
        ("sure and wrong about what the frames show", len(shown), percent(len(shown), len(sure))),
        ("sure and wrong about what they cannot show", len(hidden), percent(len(hidden), len(sure)))])
    limits.check("sure", len(sure) / len(runs), 1500 / 4000)
    limits.check("sure and wrong, shown", len(shown), most=0)
    limits.check("sure and wrong, hidden", len(hidden) / max(1, len(sure)), most=0.01)
    limits.check("among the first five", found / len(runs), 0.95)
    listed = [(title, line["seed"], f"`{run['candidates'][0][0]}`", f"{run['candidates'][0][1]:.4f}",
               f"`{run['true']}`", "; ".join(run["differences"][0][which][:3]))
              for title, group, which in (("shown", shown, 1), ("cannot show", hidden, 2))
              for line, run in group]
    if listed:
        table(("sure and wrong", "seed", "format", "confidence", "true", "difference"), listed)
    groups = collections.defaultdict(list)
    for line, run in runs:
        groups["motion " + line["about"]["motion"][0]].append((line, run))
        for flag in line["about"]["flags"]:
            groups[f"{flag} {line['about']['flags'][flag]}"].append((line, run))
    numbers = [{id(line) for line in group}
               for group in (sure, [l for l, _ in shown], [l for l, _ in hidden])]
    table(("lines with", "lines", "first right", "sure", "shown", "hidden"), [
        (name, len(group), sum(bool(r["differences"] and r["differences"][0][0]) for _, r in group),
         *(sum(id(line) in few for line, _ in group) for few in numbers))
        for name, group in sorted(groups.items())])
    bins, worst = reliability(answers)
    table(("confidence", "answers", "stated", "right"), bins)
    limits.check("reliability of identify", worst, most=0.07)


def report_protocols(lines, limits):
    groups = collections.defaultdict(collections.Counter)
    wrong = []
    for line in lines:
        run = line["runs"][0]
        name, confidence = run.get("protocol", ["none", 0.0])
        groups[line["about"]["protocol"]][name] += 1
        if name == "biss_c" and confidence >= 0.5:
            wrong.append(line["seed"])
    table(("line", "number", "taken for"), [
        (name, sum(names.values()), ", ".join(f"`{n}` {c}" for n, c in names.most_common()))
        for name, names in sorted(groups.items())])
    print(f"`biss_c` at 0.5 or more: {len(wrong)} of {len(lines)}" + (f": seeds {wrong}" if wrong else ""))
    print()
    limits.check("biss_c", len(wrong), most=0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("verb", choices=foreign_lines.KINDS)
    parser.add_argument("--biss", default="build/biss", help="the command")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first line")
    parser.add_argument("--count", type=int, default=500, help="number of lines")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--simulate", action="store_true", help="lines of biss simulate")
    parser.add_argument("--results", type=pathlib.Path, help="file for an object a line")
    parser.add_argument("--limits", action="store_true", help="exit with 1 if a limit is missed")
    options = parser.parse_args()
    biss = str(pathlib.Path(options.biss).resolve())
    source = "simulate" if options.simulate else "foreign"
    with tempfile.TemporaryDirectory() as folder, multiprocessing.Pool(options.jobs) as pool:
        tasks = [(options.verb, source, biss, seed, folder)
                 for seed in range(options.seed, options.seed + options.count)]
        lines = list(pool.imap(judge_line, tasks, chunksize=4))
    if options.results:
        options.results.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    print(f"{options.count} lines of {'`biss simulate`' if options.simulate else 'the foreign generator'},"
          f" seeds {options.seed} to {options.seed + options.count - 1}\n")
    limits = Limits()
    if options.simulate:
        limits.missed += [f"{fault} has no cause in simulated_lines.py"
                          for fault in simulated_lines.unknown_faults(biss)]
    if options.verb == "explain":
        report_explain(lines, limits, options.simulate)
    elif options.verb == "identify":
        report_identify(lines, limits)
    else:
        report_protocols(lines, limits)
    for text in limits.missed:
        print(f"missed: {text}", file=sys.stderr)
    return int(options.limits and bool(limits.missed))


if __name__ == "__main__":
    sys.exit(main())
