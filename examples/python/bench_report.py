#!/usr/bin/python3
"""bench_report.py FOLDER

An encoder on a bench: simulates a damaged link, reads its positions into NumPy, prints why the link
does not work, and follows it live, as a data logger would.
"""

import pathlib
import sys

import numpy as np

import biss

FORMAT = "resolute-26"


def main() -> None:
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    made = biss.simulate(FORMAT, clock="5MHz", cable="20m", cycles=2000, fault=["flip:0.02"], seed=1)

    # All rows at once, as arrays. Empty cells are masked. `unwrapped` continues when `position`
    # begins again at 0.
    rows = biss.decode(made.capture, format=FORMAT, unwrap=True)
    good = rows.good()
    steps = np.diff(rows["unwrapped"][good])
    print(f"{rows.rows} requests, {good.sum()} positions, largest step {abs(steps).max()} counts")
    print(f"line delay {rows['line_delay_ns'].mean():.1f} ns")

    # The likely faults of the link, and the remedies.
    for finding in biss.explain(made.capture, format=FORMAT)[:2]:
        print(f"{finding['cause']} ({finding['likelihood']}): {finding['remedy']}")

    # The same capture piece by piece, as from a data logger, with the fields on the line.
    times, ma, slo = made.capture.arrays
    decoder = biss.Decoder(FORMAT, fields=True, beginning=4000)
    wrong = 0
    for part in np.array_split(np.arange(len(times)), 20):
        for row in decoder.edges(times[part], ma[part], slo[part]):
            wrong += any(field.wrong for field in row.fields)
    for row in decoder.finish():
        wrong += any(field.wrong for field in row.fields)
    print(f"{wrong} requests with a wrong field")

    # The files that other tools read.
    biss.run("decode", made.capture, format=FORMAT, to="csv", output=folder / "rows.csv")
    biss.run("convert", made.capture, output=folder / "line.vcd")


main()
