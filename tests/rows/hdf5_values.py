"""hdf5_values.py BISS OCTAVE

Decodes simulated captures to CSV and to HDF5, and compares every value: as h5py reads it, and as
Octave loads it.
"""

import csv
import math
import pathlib
import subprocess
import sys
import tempfile

import h5py

FAULTS = ["flip:0.02", "nE:0.02", "glitch_ma:0.02", "no_answer:0.02", "lost_clock:0.02", "cut:0.02"]
CASES = [
    # Format of the encoder, cycles, options of decode.
    ("pos26,nE,nW,crc6", 3000, ["-f", "pos26,nE,nW,crc6", "--unwrap", "--scale", "2^26/turn"]),
    ("pos26,nE,nW,crc6", 500, ["-f", "none"]),
    ("pos62,E,W,crc16", 500, ["-f", "pos62,E,W,crc16", "--unwrap"]),
    ("mt12,st20,nE,nW,lc6,crc16", 2000, ["-f", "mt12,st20,nE,nW,lc6,crc16", "--velocity"]),
    ("fs-36-28", 40000, ["-f", "fs-36-28"]),
    ("resolute-26", 100, ["-f", "resolute-26", "--only-errors", "--until", "-1s"]),
]

# Prints each column of a file on a line: its name, its class, and its values as exact text. printf
# rounds integers of 64 bits, so these are two numbers of 32 bits.
OCTAVE = r"""
rows = load(argv(){1});
for [value, name] = rows
  printf("%s\t%s", name, class(value));
  if strfind(name, '_names')
    printf("\t%s", cellstr(char(value)){:});
  elseif any(strcmp(class(value), {'int64', 'uint64'}))
    bits = typecast(value'(:)', 'uint64');
    printf("\t%d:%d", [bitshift(bits, -32); bitand(bits, uint64(4294967295))]);
  else
    printf("\t%.17g", value');
  end
  printf("\n");
end
"""


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode > 1:
        sys.exit(f"{' '.join(words)}: {done.returncode}: {done.stderr}")
    return done.stdout


def text_of(units):
    return b"".join(int(unit).to_bytes(2, "little") for unit in units).decode("utf-16").rstrip()


def columns_of_h5py(path):
    """Name: values; those of a data set with several words one after the other, row by row."""
    with h5py.File(path) as rows:
        columns = {}
        for name, data in rows.items():
            values = data[()].T
            if name.endswith("_names"):
                columns[name] = [text_of(row) for row in values]
            else:
                columns[name] = [value for row in values.tolist() for value in row]
        return columns


def number_of(kind, text):
    if kind == "double":
        return float(text)
    if ":" not in text:
        return int(text)
    high, low = (int(half) for half in text.split(":"))
    value = high << 32 | low
    return value - (1 << 64) if kind == "int64" and value >= 1 << 63 else value


def columns_of_octave(octave, script, path):
    columns = {}
    for line in run(octave, "--quiet", "--no-init-file", script, path).splitlines():
        name, kind, *values = line.split("\t")
        if name.endswith("_names"):
            columns[name] = [value.rstrip() for value in values]
        else:
            columns[name] = [number_of(kind, value) for value in values if value.strip(":")]
    return columns


def absent_of(value, name):
    if isinstance(value, float):
        return math.isnan(value)
    return value in ((-(2**63), 2**64 - 1) if name.startswith(("position", "unwrapped")) else (255,))


def cell_of(columns, name, row, count):
    """The value of a row as in the CSV, but numbers as numbers; "" where it is absent."""
    values = columns[name]
    if name == "raw":
        words = len(values) // count
        number = 0
        for word in values[row * words:(row + 1) * words]:
            number = number << 64 | int(word)
        bits = columns["raw_bits"][row]
        return f"0x{number:0{(bits + 3) // 4}X}" if bits else ""
    value = values[row]
    if name in ("status", "safety", "limits"):
        return columns[name + "_names"][value - 1] if value else ""
    return "" if absent_of(value, name) else value


def differences(rows, columns, reader):
    for name in rows[0]:
        for number, row in enumerate(rows):
            found = cell_of(columns, name, number, len(rows))
            text = row[name]
            same = found == text or (text != "" and found != "" and not isinstance(found, str) and
                                     (int(text) == found if isinstance(found, int) else
                                      float(text) == found))
            if not same:
                yield f"{reader}: {name} of row {number} is {found!r}, in the CSV {text!r}"


def main():
    biss, octave = sys.argv[1:]
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        script = folder / "columns.m"
        script.write_text(OCTAVE, encoding="utf-8")
        for encoder, cycles, options in CASES:
            capture, table, rows_file = (str(folder / n) for n in ("line.sr", "rows.csv", "rows.h5"))
            faults = [word for fault in FAULTS for word in ("--fault", fault)]
            run(biss, "simulate", "-f", encoder, "--cycles", str(cycles), *faults, "--seed", "7",
                "-o", capture)
            run(biss, "decode", capture, *options, "--to", "csv", "-o", table)
            run(biss, "decode", capture, *options, "--to", "hdf5", "-o", rows_file)
            with open(table, encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            for reader, columns in (("h5py", columns_of_h5py(rows_file)),
                                    ("Octave", columns_of_octave(octave, str(script), rows_file))):
                if rows:
                    wrong += differences(rows, columns, f"{encoder} {reader}")
                elif columns["time_ns"]:
                    wrong.append(f"{encoder} {reader}: there should be no rows")
            print(f"{encoder} {' '.join(options)}: {len(rows)} rows compared")
    for line in wrong[:20]:
        print(line)
    sys.exit(1 if wrong else 0)


main()
