"""Empty cells: no position that was not received looks like a number, and which rows are good."""

import copy
import io
import pickle

import numpy as np
import pandas
import pytest

import biss
from conftest import FORMAT, edges_of, rows_of, simulated

GAPS = ["--fault", "no_answer:0.1", "--fault", "no_answer@5", "--fault", "no_answer@6", "--fault",
        "flip:0.1", "--motion", "random", "--cycles", 300, "--seed", 9]


@pytest.fixture(scope="module")
def captures(folder):
    """Captures of encoders with positions of many widths, with gaps in pairs too."""
    def one(text):
        return simulated(folder / f"gaps{abs(hash(text))}.csv", "-f", text, *GAPS,
                         *([] if "nE" not in text else ["--fault", "nE:0.2"]))
    return {text: one(text) for text in (
        "pos1,crc16", "pos26,nE,nW,crc6", "pos55,nE,nW,crc6", "pos63,crc16", "pos64,crc16",
        "mt12,st20,nE,nW,lc6,crc16", "pos36,nE,nW,crc6+pos64,crc16")}


def copies_of(column):
    """The column after what a script may do with it, each with the numbers of its rows."""
    rows = np.arange(len(column))
    file = io.BytesIO()
    np.save(file, column)
    file.seek(0)
    yield from ((each, rows) for each in (
        column, column.copy(), copy.copy(column), copy.deepcopy(column), column.view(),
        pickle.loads(pickle.dumps(column)), np.load(file, allow_pickle=False)))
    yield column[3:9], rows[3:9]
    yield column[::-2], rows[::-2]


def numbers_without_mask(column):
    """The values if the mask is dropped."""
    yield np.asarray(column)
    yield np.array(column)
    if isinstance(column, np.ma.MaskedArray):
        yield column.data
        yield column.filled()
    yield np.concatenate([column, column])[:len(column)]
    yield np.where(np.ones(len(column), bool), column, column)


def assert_no_value(values, bits):
    for value in values.tolist():
        assert value != value or not 0 <= value < 1 << bits, (value, bits)


def test_GapWhereTheMaskIsDropped_IsNoPosition(captures):
    gaps = 0
    for text, path in captures.items():
        columns = biss.decode(path, format=text, unwrap=True)
        width = 32 if text[0] == "m" else int(text[3:5].rstrip(","))
        for name, bits in (("position", width), ("position2", 64), ("mt", 12), ("st", 20), ("lc", 6),
                           ("unwrapped", 62), ("nE", 1), ("nW", 1), ("crc_ok", 1), ("ack_ns", 62)):
            if name not in columns:
                continue
            absent = np.ma.getmaskarray(columns[name])
            gaps += absent.sum()
            for made, rows in copies_of(columns[name]):
                for values in numbers_without_mask(made):
                    assert_no_value(values[absent[rows]], bits)
                    assert np.array_equal(values[~absent[rows]],
                                          columns[name].data[rows][~absent[rows]])
    assert gaps > 1000


def test_AsarrayOfASubclass_AsksNoMethodThatCouldRefuse():
    # So the documents must say it. If NumPy asks one day, a masked column can refuse.
    class Refusing(np.ma.MaskedArray):
        def __array__(self, *args, **options):
            raise biss.UsageError("the mask would be dropped")

    column = np.arange(3).view(Refusing)
    column[1] = np.ma.masked
    assert type(np.asarray(column)) is np.ndarray
    assert type(np.array(column)) is np.ndarray


def test_DifferencesAtGaps_AreNoSteps(captures):
    for text, path in captures.items():
        columns = biss.decode(path, format=text, unwrap=True)
        for name in ("position", "unwrapped"):
            column = columns[name]
            steps = np.diff(column)
            absent = np.ma.getmaskarray(column)
            assert np.array_equal(np.ma.getmaskarray(steps), absent[1:] | absent[:-1])
            assert_no_value(np.asarray(steps)[absent[1:] | absent[:-1]], 62)
            assert absent[5] and absent[6]


def test_FunctionThatBlendsGapsIntoResults_IsRefused(captures):
    for text, path in captures.items():
        columns = biss.decode(path, format=text)
        position = columns["position"]
        times = np.asarray(columns["time_ns"])
        for use in (lambda p: np.interp(times[::3] + 1, times, p), np.median,
                    lambda p: np.percentile(p, 50), lambda p: np.quantile(p, 0.5), np.nanmedian):
            with pytest.raises(biss.UsageError, match="ignores the mask"):
                use(position)
            with pytest.raises(biss.UsageError, match="ignores the mask"):
                use(position[2:9] * 2)
        received = columns["status"] == "ok"
        if "64" not in text[:5]:
            assert np.interp(times[received][-1], times[received], position[received]) == float(
                position[received][-1])
            assert np.ma.median(position) == np.median(position.compressed())


def test_FloatsThatDoNotHoldThePositions_AreRefused(captures):
    wide = biss.decode(captures["pos55,nE,nW,crc6"], format="pos55,nE,nW,crc6")
    for use in (lambda column: column.astype(float), pandas.Series,
                lambda column: pandas.DataFrame({"position": column})):
        with pytest.raises(biss.UsageError, match="to_pandas"):
            use(wide["position"])
        # 26 bits are exact, and so is a column without gaps as an integer.
        narrow = biss.decode(captures[FORMAT], format=FORMAT)["position"]
        made = np.ravel(use(narrow))
        assert np.array_equal(made[~narrow.mask], narrow.compressed())
    assert wide["position"].astype(float, casting="unsafe").dtype == np.float64
    assert wide["position"].astype(np.int64).dtype == np.int64


def test_PandasTable_HasTheRowsOfTheCommand(captures):
    for text, path in captures.items():
        table = biss.decode(path, format=text, unwrap=True).to_pandas()
        rows = rows_of(path, "-f", text, "--unwrap")
        assert [name for name in table if name != "raw_bits"] == list(rows[0])
        for name in rows[0]:
            for value, row in zip(table[name], rows):
                if value is pandas.NA or value != value:
                    assert row[name] == "", name
                elif name == "raw":
                    assert value == int(row[name], 16)
                elif isinstance(value, float):
                    assert value == float(row[name])
                else:
                    assert str(value) == row[name], name
        for name, kind in (("position", "UInt64"), ("nE", "UInt8"), ("unwrapped", "Int64"),
                           ("ack_ns", "float64"), ("status", "string"), ("raw_bits", "UInt16")):
            assert table[name].dtype == kind, name
        assert table.index.equals(pandas.to_timedelta([round(float(row["time_ns"])) for row in rows]))
        by_status = table.groupby("status").position.max()
        assert by_status["ok"] == max(int(row["position"]) for row in rows if row["status"] == "ok")
        assert table.position.resample("1s").max()[0] == by_status["ok"]
        with pytest.raises(TypeError):
            np.interp([1.0], table.time_ns, table.position)


def test_PandasTableOfFewColumnsOrRows_IsMade(captures):
    path = captures[FORMAT]
    some = biss.decode(path, format=FORMAT, columns="status,position").to_pandas()
    assert list(some) == ["status", "position"] and list(some.index[:3]) == [0, 1, 2]
    one = biss.decode(path, format=FORMAT, every=1000).to_pandas()
    assert one.shape[0] == 1 and one.position.dtype == "UInt64"
    ideal = simulated(path.with_name("ideal.csv"), "-f", FORMAT, "--cycles", 20)
    none = biss.decode(ideal, format=FORMAT, only_errors=True)
    assert none.to_pandas().shape[0] == none.good().size == none["position"].size == 0


def test_ReadingACsvAsTheDocumentSays_IsExact(captures):
    path = captures["pos55,nE,nW,crc6"]
    rows = rows_of(path, "-f", "pos55,nE,nW,crc6")
    file = path.with_name("rows.csv")
    biss.run("decode", path, format="pos55,nE,nW,crc6", to="csv", output=file)
    table = pandas.read_csv(file, dtype={"position": "string"}).astype({"position": "UInt64"})
    assert ["" if value is pandas.NA else str(value) for value in table.position] == [
        row["position"] for row in rows]
    biss.run("decode", path, format="pos55,nE,nW,crc6", to="jsonl", output=file)
    lines = pandas.read_json(file, lines=True, dtype=False)
    assert ["" if pandas.isna(value) else str(value) for value in lines.position] == [
        row["position"] for row in rows]


def test_RowsOfADecoderAsTheDocumentSays_AreExact(captures):
    decoder = biss.Decoder("pos55,nE,nW,crc6")
    rows = decoder.edges(*edges_of(captures["pos55,nE,nW,crc6"])) + decoder.finish()
    table = pandas.DataFrame(rows, dtype=object)
    assert table.position.tolist() == [row["position"] for row in rows]
    assert None in table.position.tolist() and max(filter(None, table.position)) > 1 << 53


def test_GoodRows_HaveAStatusAndNoErrorInAnyChannel(captures, damaged):
    cases = list(captures.items())
    cases += [(FORMAT, damaged), ("none", damaged)]
    for text, path in cases:
        rows = rows_of(path, "-f", text)
        wanted = [row["status"] == "ok" and all(
            row.get(f"nE{k}", "1") != "0" and row.get(f"crc{k}_ok", "1") != "0" for k in ("", "2"))
            for row in rows]
        columns = biss.decode(path, format=text)
        good = columns.good()
        assert good.dtype == bool and type(good) is np.ndarray and good.tolist() == wanted
        assert not np.ma.is_masked(columns["position"][good])
        if "nE" in text:
            assert 0 < good.sum() < (columns["status"] == "ok").sum()
    for given in ("status,crc_ok", "status,nE", "nE,crc_ok", "time_ns,position"):
        with pytest.raises(biss.UsageError, match=r"good\(\) needs the column"):
            biss.decode(damaged, format=FORMAT, columns=given).good()
    both = "pos36,nE,nW,crc6+pos64,crc16"
    with pytest.raises(biss.UsageError, match="column nE2"):
        biss.decode(captures[both], format=both, columns="status,nE,crc_ok,position2").good()


def test_SpiBuffers_HaveGapsAndGoodRowsToo():
    for text in ("pos26,nE,nW,crc6", "pos64,crc16", "pos20,nE,nW,crc6+pos12,nE,nW,crc6"):
        format = biss.Format(text)
        reader = biss.SpiReader(format, 5_000_000, line_delay_max_ps=1_000_000,
                                no_error_flag="nE" not in text)
        buffers = np.zeros((40, reader.transfer_bytes), np.uint8)
        for i in range(40):
            channels = [biss.Channel(100 + i, nE="nE" not in text or (i + k) % 4 != 0)
                        for k in range(len(format.channels))]
            bits = format.encode(*channels, ack_clocks=5 + i % 7)
            buffers[i, :len(bits.data)] = np.frombuffer(bits.data, np.uint8)
        buffers[17, 3] ^= 0x10
        buffers[18] = 0xFF
        columns = reader.read_all(buffers)
        wanted = []
        for i in range(40):
            try:
                wanted.append(reader.read(buffers[i]).trusted)
            except biss.FrameError:
                wanted.append(False)
        assert columns.good().tolist() == wanted and 0 < sum(wanted) < 39
        for value in np.asarray(columns["position"])[17:19].ravel().tolist():
            assert value != value or not 0 <= value < 1 << min(reader.format.payload_bits, 64)
        assert not np.isin(np.asarray(columns["nE"])[17:19], (0, 1)).any()
        for value in np.asarray(columns["life_counter"])[17:19].ravel().tolist():
            assert value >= 1 << 31
    assert reader.read_all(np.zeros((0, reader.transfer_bytes), np.uint8)).good().size == 0
