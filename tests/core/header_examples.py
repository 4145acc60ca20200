#!/usr/bin/python3
"""header_examples.py ROOT: does tests/core/header_examples.cpp hold each example of biss/?

An example is a run of comment lines indented by two spaces more than the text, of which one ends
with a semicolon. Its lines stand, in their order, in the section `// ---- HEADER` of the file.
"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])


def examples_of(header):
    run = []
    for line in (root / header).read_text("utf-8").splitlines() + [""]:
        match = re.match(r"\s*///?   (.*)", line)
        if match:
            run.append(match.group(1).strip())
        else:
            if any(re.search(r";(\s*//.*)?$", each) for each in run):
                yield run
            run = []


text = (root / "tests/core/header_examples.cpp").read_text("utf-8")
sections = dict(re.findall(r"^// ---- (\S+)\n(.*?)(?=^// ---- |\Z)", text, re.M | re.S))
problems = 0
found = 0
for path in sorted((root / "biss").rglob("*.hpp")):
    header = path.relative_to(root).as_posix()
    for example in examples_of(header):
        found += 1
        ahead = iter(line.strip() for line in sections.get(header, "").splitlines())
        missing = next((line for line in example if line not in ahead), None)
        if missing is not None:
            print(f"{header}: header_examples.cpp does not hold {missing!r} of its example")
            problems += 1
if found < 15:
    print(f"only {found} examples found")
    problems += 1
sys.exit(1 if problems else 0)
