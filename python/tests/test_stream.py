"""biss.Decoder against the rows of the command, cell by cell, and the fields of each row."""

import functools
import random
import sys
import threading

import numpy as np
import pytest

import biss
from conftest import FORMAT, edges_of, rows_of, simulated, text_of


def assert_same(rows, wanted):
    assert len(rows) == len(wanted) > 0
    for row, texts in zip(rows, wanted):
        assert {name: text_of(value) for name, value in row.items()} == texts


def streamed(capture, chunk, **options):
    times, ma, slo = capture
    decoder = biss.Decoder(**options)
    rows = []
    for i in range(0, len(times), chunk):
        part = slice(i, i + chunk)
        rows += decoder.edges(times[part], ma[part], slo[part])
    return rows + decoder.finish(), decoder


@pytest.mark.parametrize("fields", [False, True])
@pytest.mark.parametrize("chunk", [1 << 30, 4096, 777, 13])
def test_Chunks_GiveTheRowsOfTheCommand(damaged, fields, chunk):
    rows, decoder = streamed(edges_of(damaged), chunk, format=FORMAT, fields=fields)
    assert_same(rows, rows_of(damaged, "-f", FORMAT))
    assert decoder.columns == list(rows[0])
    assert decoder.format == FORMAT


def test_SingleEdges_GiveTheRowsOfTheCommand(damaged):
    decoder = biss.Decoder(FORMAT, beginning=3000)
    rows = []
    early = 0
    for i, edge in enumerate(zip(*(array.tolist() for array in edges_of(damaged)))):
        rows += decoder.edges(*edge)
        early = len(rows) if i == 100_000 else early
    assert early > 500
    assert_same(rows + decoder.finish(), rows_of(damaged, "-f", FORMAT))


def test_NoFormat_IsFoundInTheBeginning(damaged, noisy):
    rows, decoder = streamed(edges_of(noisy), 5000)
    assert_same(rows, rows_of(noisy))
    assert decoder.format is not None and "nE,nW,crc6" in decoder.format
    rows, decoder = streamed(edges_of(damaged), 5000)
    assert_same(rows, rows_of(damaged))


def test_Samples_GiveTheRowsOfTheRawFile(sampled, folder):
    path = folder / "stream.bin"
    sampled.tofile(path)
    wanted = rows_of(path, "--raw-rate", "100MHz", "-f", FORMAT, "--ma", "D0", "--slo", "D1")
    decoder = biss.Decoder(FORMAT, sample_rate=100_000_000, fields=True)
    rows = []
    for part in np.array_split(sampled, 50):
        rows += decoder.samples(part)
    assert_same(rows + decoder.finish(), wanted)
    # The same as changes at the samples of these numbers.
    numbers = np.flatnonzero(np.diff(sampled, prepend=sampled[0] ^ 1))
    decoder = biss.Decoder(FORMAT, sample_rate=100_000_000)
    rows = decoder.changes(numbers, sampled[numbers] & 1, sampled[numbers] >> 1 & 1)
    assert_same(rows + decoder.finish(end_sample=len(sampled) - 1), wanted)


def test_RateOfNoWholePeriod_GivesExactTimes(folder):
    path = simulated(folder / "odd.bin", "-f", FORMAT, "--cycles", 200, "--sample-rate", "48MHz")
    samples = np.fromfile(path, dtype=np.uint8)
    decoder = biss.Decoder(FORMAT, sample_rate=48_000_000)
    assert_same(decoder.samples(samples) + decoder.finish(),
                rows_of(path, "--raw-rate", "48MHz", "-f", FORMAT, "--ma", "D0", "--slo", "D1"))


def test_InvertedLinesAndSafety_AreAsByTheCommand(folder):
    path = simulated(folder / "safety.csv", "-f", "fs-36-28", "--cycles", 300, "--fault",
                     "repeat:0.02", "--fault", "swap_slo:0.01")
    times, ma, slo = edges_of(path)
    rows, _ = streamed((times, 1 - ma, 1 - slo), 999, format="fs-36-28", fields=True)
    assert_same(rows, rows_of(path, "-f", "fs-36-28"))
    assert {field.name for row in rows for field in row.fields} >= {"crc", "crc.2", "lc.2"}


def test_OptionsThatChooseRows_KeepTheFieldsWithTheirRows(damaged):
    edges = edges_of(damaged)
    whole, _ = streamed(edges, 2000, format=FORMAT, fields=True)
    some, _ = streamed(edges, 2000, format=FORMAT, fields=True, only_errors=True)
    assert_same(some, rows_of(damaged, "-f", FORMAT, "--only-errors"))
    by_number = {row["cycle"]: row for row in whole}
    for row in some:
        assert row.fields == by_number[row["cycle"]].fields


def test_Fields_SayWhatTheRowSays(damaged):
    rows, _ = streamed(edges_of(damaged), 3000, format=FORMAT, fields=True)
    for row, following in zip(rows, rows[1:]):
        assert row.begin_ps == round(row["time_ns"] * 1000) < row.end_ps <= following.begin_ps
        fields = {field.name: field for field in row.fields}
        for a, b in zip(row.fields, row.fields[1:]):
            assert a.begin_ps <= b.begin_ps and a.begin_ps < a.end_ps
        frame = [field for field in row.fields if field.track == "frame"]
        assert all(a.end_ps <= b.begin_ps for a, b in zip(frame, frame[1:]))
        if row["status"] == "ok":
            assert [field.name for field in frame] == [
                "request", "ACK", "START", "CDS", "pos", "nE", "nW", "crc", "STOP", "timeout"]
            assert fields["pos"].value == row["position"]
            assert fields["nE"].value == row["nE"] and fields["nW"].value == row["nW"]
            assert fields["CDS"].value == 0 and fields["STOP"].value == 0
            assert fields["crc"].expected is None and not fields["crc"].wrong
            assert fields["pos"].text == f"pos={row['position']}"
        elif row["status"] == "crc":
            assert fields["crc"].wrong and fields["crc"].expected != fields["crc"].value
    assert all(row.fields for row in rows if row["status"] in ("ok", "crc", "cds", "stop_bit"))


def test_WrongUse_IsNamed(damaged):
    times, ma, slo = edges_of(damaged)
    with pytest.raises(biss.UsageError, match="pos99"):
        biss.Decoder("pos99")
    with pytest.raises(biss.UsageError, match="unknown option '--nonsense'"):
        biss.Decoder(FORMAT, nonsense=1)
    for options in ({"output": "x"}, {"to": "csv"}, {"columns": "time_ns"}, {"each": True},
                    {"fail_on": "any"}, {"help": True}, {"beginning": 0}, {"sample_rate": -1}):
        with pytest.raises(biss.UsageError):
            biss.Decoder(FORMAT, **options)
    for options in ({"sample_rate": 1e8}, {"sample_rate": "100MHz"}, {"beginning": 1.5}):
        with pytest.raises(TypeError, match="a whole number is needed"):
            biss.Decoder(FORMAT, **options)
    decoder = biss.Decoder(FORMAT)
    with pytest.raises(biss.UsageError, match="sample_rate"):
        decoder.samples(ma)
    sampling = biss.Decoder(FORMAT, sample_rate=100_000_000)
    with pytest.raises(biss.UsageError, match="ma=8 and slo=1 are not two bits of a sample of 8 bits"):
        sampling.samples(ma, ma=8)
    with pytest.raises(biss.UsageError, match="slo: -1"):
        sampling.samples(ma, slo=-1)
    with pytest.raises(biss.UsageError, match="end_sample: -1"):
        sampling.finish(end_sample=-1)
    with pytest.raises(TypeError, match="times_ps: a whole number is needed"):
        decoder.edges(0.5, 0, 0)
    with pytest.raises(biss.UsageError, match="times_ps"):
        decoder.edges(1 << 63, 0, 0)
    with pytest.raises(biss.UsageError, match="element 1: time runs backwards"):
        decoder.edges(times[1::-1].copy(), ma[:2], slo[:2])
    decoder.edges(times, ma, slo)
    with pytest.raises(biss.UsageError, match="backwards"):
        decoder.edges(0, 0, 0)
    decoder.finish()
    with pytest.raises(biss.UsageError, match="finished"):
        decoder.edges(times, ma, slo)
    assert decoder.finish() == []
    empty = biss.Decoder(FORMAT)
    with pytest.raises(biss.DataError):
        empty.finish()
    quiet = biss.Decoder(FORMAT)
    quiet.edges(times[:1], ma[:1], slo[:1])
    with pytest.raises(biss.DataError):
        quiet.finish(end_ps=10**12)


def test_SamplesBeforeTheLastEdge_AreNamed(sampled):
    for earlier in (lambda decoder: decoder.samples(sampled),
                    lambda decoder: decoder.changes(np.array([5]), sampled[:1], sampled[:1]),
                    lambda decoder: decoder.changes(5, 0, 1)):
        decoder = biss.Decoder(FORMAT, sample_rate=100_000_000)
        decoder.edges(10**12, True, True)
        with pytest.raises(biss.UsageError, match="element 0: time runs backwards"):
            earlier(decoder)


def test_SamplesAfterChanges_BeginWithTheirOwnLevels(sampled, folder):
    path = folder / "changes.bin"
    sampled.tofile(path)
    # A pulse: at its end the levels are those before it.
    edges = np.flatnonzero(np.diff(sampled)) + 1
    begin, end = next((a, b) for a, b in zip(edges[100:], edges[101:])
                      if sampled[a - 1] == sampled[b])
    decoder = biss.Decoder(FORMAT, sample_rate=100_000_000)
    rows = decoder.samples(sampled[:begin])
    numbers = np.arange(begin, end)
    rows += decoder.changes(numbers, sampled[numbers] & 1, sampled[numbers] >> 1 & 1)
    rows += decoder.samples(sampled[end:])
    assert_same(rows + decoder.finish(),
                rows_of(path, "--raw-rate", "100MHz", "-f", FORMAT, "--ma", "D0", "--slo", "D1"))


def test_ThreadsWithOneDecoder_TakeTurns(damaged, request):
    request.addfinalizer(functools.partial(sys.setswitchinterval, sys.getswitchinterval()))
    sys.setswitchinterval(1e-6)
    times, ma, slo = edges_of(damaged)
    wanted = len(rows_of(damaged, "-f", FORMAT))
    for _ in range(3):
        decoder = biss.Decoder(FORMAT, beginning=1000, fields=True)
        ended = threading.Event()
        others = []

        def ask():
            while not ended.is_set():
                others.extend(decoder.rows())
                assert decoder.format in (None, FORMAT)

        threads = [threading.Thread(target=ask) for _ in range(2)]
        for thread in threads:
            thread.start()
        rows = []
        for i in range(0, len(times), 50):
            rows += decoder.edges(times[i:i + 50], ma[i:i + 50], slo[i:i + 50])
        ended.set()
        for thread in threads:
            thread.join()
        rows += others + decoder.finish()
        assert sorted(row["cycle"] for row in rows) == list(range(wanted))


def test_RandomEdges_EndWithRowsOrANamedError():
    random.seed(15)
    numbers = np.random.default_rng(15)
    for _ in range(300):
        count = random.choice([1, 2, 50, 2000])
        times = np.cumsum(numbers.integers(0, random.choice([2, 10**6, 10**13]), count))
        levels = numbers.integers(0, 2, (2, count)).astype(np.uint8)
        decoder = biss.Decoder(random.choice([None, FORMAT, "none", "fs-36-28"]),
                               fields=random.random() < 0.5, beginning=random.choice([1, 100, 9999]))
        try:
            rows = []
            for part in np.array_split(np.arange(count), random.choice([1, 7])):
                rows += decoder.edges(times[part], levels[0][part], levels[1][part])
            rows += decoder.finish()
        except biss.Error as error:
            assert str(error)
            continue
        assert [row["cycle"] for row in rows] == list(range(len(rows)))
