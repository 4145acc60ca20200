"""biss.decode() against the rows of the command, cell by cell."""

import threading
import time

import numpy as np
import pytest

import biss
from conftest import FORMAT, edges_of, rows_of, simulated


def cell_of(columns, name, row):
    if columns[name].mask is not np.ma.nomask and np.any(columns[name].mask[row]):
        return ""
    if name == "raw":
        words = np.atleast_1d(columns["raw"].data[row])
        number = int.from_bytes(b"".join(int(word).to_bytes(8, "big") for word in words), "big")
        return "0x" + format(number, f"0{(int(columns['raw_bits'][row]) + 3) // 4}X")
    if name.endswith("_ns"):
        count = int(columns.picoseconds(name)[row])
        text = f"{count // 1000}.{count % 1000:03}" if count >= 0 else None
        return text.rstrip("0").rstrip(".")
    value = columns[name].data[row]
    return np.format_float_positional(value, trim="-") if value.dtype.kind == "f" else str(value)


def assert_same(columns, rows):
    assert columns.rows == len(rows) > 0
    assert [name for name in columns if name != "raw_bits"] == list(rows[0])
    for number, row in enumerate(rows):
        for name, text in row.items():
            assert cell_of(columns, name, number) == text, (number, name)


def test_DamagedFile_GivesTheRowsOfTheCommand(damaged):
    rows = rows_of(damaged, "-f", FORMAT)
    assert len({row["status"] for row in rows}) > 5
    assert_same(biss.decode(str(damaged), format=FORMAT), rows)
    assert_same(biss.decode(damaged, format=FORMAT, threads=1), rows)


def test_NoFormat_IsIdentifiedAsByTheCommand(noisy):
    columns = biss.decode(noisy)
    assert_same(columns, rows_of(noisy))
    assert not columns["position"].mask.all()
    assert_same(biss.decode(biss.Capture.edges(*edges_of(noisy))), rows_of(noisy))


def test_StructureOnly_GivesLongBitStrings(damaged):
    columns = biss.decode(damaged, format="none")
    assert_same(columns, rows_of(damaged, "-f", "none"))


def test_Edges_GiveTheRowsOfTheFile(damaged):
    times, ma, slo = edges_of(damaged)
    rows = rows_of(damaged, "-f", FORMAT)
    assert_same(biss.decode(biss.Capture.edges(times, ma, slo), format=FORMAT), rows)
    assert_same(biss.decode(biss.Capture.edges(times, ma != 0, slo != 0)), rows_of(damaged))
    # The lines exchanged: they are taken by their names, so the rows are others.
    swapped = biss.decode(biss.Capture.edges(times, slo, ma), format=FORMAT, ma="SLO", slo="MA")
    assert_same(swapped, rows)


def test_LoadedCapture_GivesTheRowsOfTheFile(damaged):
    capture = biss.Capture.load(damaged)
    for mine, theirs in zip(biss.Capture.edges(*capture.arrays).arrays, capture.arrays):
        assert mine is theirs
    assert_same(biss.decode(capture, format=FORMAT), rows_of(damaged, "-f", FORMAT))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.uint32, np.uint64])
def test_Samples_GiveTheRowsOfTheRawFile(sampled, folder, dtype):
    samples = sampled.astype(dtype)
    path = folder / f"{np.dtype(dtype).name}.bin"
    samples.tofile(path)
    words = [path, "--raw-rate", "100MHz", "--raw-bytes", samples.itemsize]
    rows = rows_of(*words, "-f", FORMAT, "--ma", "D0", "--slo", "D1")
    columns = biss.decode(samples, sample_rate=100_000_000, format=FORMAT, ma="D0", slo="D1")
    assert_same(columns, rows)
    # The lines are found by what they do, the polarity too.
    inverted = biss.decode(samples ^ dtype(2), sample_rate=100_000_000, format=FORMAT)
    assert np.array_equal(inverted["position"], columns["position"])


def test_FileInMemory_GivesTheRowsOfTheFile(damaged):
    capture = biss.Capture.content(damaged.read_bytes(), "line.csv")
    assert_same(biss.decode(capture, format=FORMAT), rows_of(damaged, "-f", FORMAT))


def test_Options_AreThoseOfTheCommand(damaged):
    assert_same(biss.decode(damaged, format=FORMAT, only_errors=True),
                rows_of(damaged, "-f", FORMAT, "--only-errors"))
    assert_same(biss.decode(damaged, format=FORMAT, every=7, since="1ms", unwrap=True, velocity=True),
                rows_of(damaged, "-f", FORMAT, "--every", 7, "--since", "1ms", "--unwrap",
                        "--velocity"))
    some = biss.decode(damaged, format=FORMAT, columns="time_ns,position")
    assert list(some) == ["time_ns", "position"]
    assert_same(some, rows_of(damaged, "-f", FORMAT, "--columns", "time_ns,position"))


def test_SeveralFiles_HaveAColumnThatTellsThem(damaged, folder):
    other = simulated(folder / "other.vcd", "-f", FORMAT, "--cycles", 20)
    assert_same(biss.decode(damaged, other, format=FORMAT),
                rows_of(damaged, other, "-f", FORMAT))


def test_SafetyFormat_HasVerdictsAndTwoChannels(folder):
    path = simulated(folder / "safe.csv", "-f", "fs-36-28", "--cycles", 400, "--fault", "repeat:0.02",
                     "--fault", "flip:0.05")
    rows = rows_of(path, "-f", "fs-36-28")
    assert len({row["safety"] for row in rows}) > 2
    assert_same(biss.decode(path, format="fs-36-28"), rows)


def test_Types_AreThoseOfTheDocument(damaged):
    columns = biss.decode(damaged, format=FORMAT)
    assert columns["position"].dtype == np.uint64
    assert columns["time_ns"].dtype == np.float64
    assert columns.picoseconds().dtype == np.int64
    assert columns["nE"].dtype == np.uint8
    assert columns["status"].dtype.kind == "U"
    assert columns.units["time_ns"] == "ns" and columns.units["position"] == "counts"
    assert columns["position"].mask[columns["status"].data != "ok"].all()
    assert "3000 request cycles" in columns.summary
    with pytest.raises(KeyError):
        columns["nothing"]
    with pytest.raises(KeyError):
        columns.picoseconds("position")


def test_Decoding_LetsOtherThreadsRun(sampled):
    many = np.tile(sampled, 40)
    counted = []
    ended = threading.Event()

    def count():
        while not ended.is_set():
            counted.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    began = time.monotonic()
    biss.decode(many, sample_rate=100_000_000, format=FORMAT)
    end = time.monotonic()
    ended.set()
    thread.join()
    assert sum(began < each < end for each in counted) >= 2
