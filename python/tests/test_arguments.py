"""Arguments that are wrong in every way: an exception with a name, never a crash."""

import concurrent.futures
import faulthandler
import os
import random
import signal
import subprocess
import threading

import numpy as np
import pytest

import biss
from conftest import FORMAT, edges_of

RATE = 100_000_000


@pytest.mark.parametrize("array", [
    np.zeros(10), np.zeros(10, np.int8), np.zeros(10, np.float32), np.zeros(10, np.complex128),
    np.full(10, np.nan), np.zeros(10, "M8[ns]"), np.array(["a"] * 10), np.array([None] * 10),
    np.zeros(10, np.dtype(np.uint16).newbyteorder(">")),
])
def test_SamplesOfAnotherType_AreATypeError(array):
    with pytest.raises(TypeError):
        biss.decode(array, sample_rate=RATE)
    with pytest.raises(TypeError):
        biss.Decoder(FORMAT, sample_rate=RATE).samples(array)
    with pytest.raises(TypeError):
        biss.decode(biss.Capture.edges(array, np.zeros(10, bool), np.zeros(10, bool)))
    with pytest.raises(TypeError):
        biss.Decoder(FORMAT).edges(array, np.zeros(10, bool), np.zeros(10, bool))


@pytest.mark.parametrize("array", [
    np.zeros((4, 4), np.uint8), np.zeros(20, np.uint8)[::2], np.zeros(20, np.uint8)[::-1],
    np.zeros((4, 4), np.uint8)[:, 0],
])
def test_SamplesOfAnotherShape_AreAUsageError(array):
    with pytest.raises(biss.UsageError):
        biss.decode(array, sample_rate=RATE)
    with pytest.raises(biss.UsageError):
        biss.Decoder(FORMAT, sample_rate=RATE).samples(array)


def test_EmptyArrays_AreNamed():
    nothing = np.zeros(0, np.uint8)
    with pytest.raises(biss.CaptureError, match="is empty"):
        biss.decode(nothing, sample_rate=RATE)
    with pytest.raises(biss.CaptureError, match="is empty"):
        biss.decode(biss.Capture.edges(np.zeros(0, np.int64), nothing, nothing))
    assert biss.Decoder(FORMAT, sample_rate=RATE).samples(nothing) == []
    assert biss.Decoder(FORMAT).edges(np.zeros(0, np.int64), nothing, nothing) == []


def test_ArraysOfDifferentLengths_AreAUsageError():
    times = np.arange(10)
    with pytest.raises(biss.UsageError):
        biss.decode(biss.Capture.edges(times, np.zeros(9, bool), np.zeros(10, bool)))
    with pytest.raises(biss.UsageError):
        biss.Decoder().edges(times, np.zeros(10, bool), np.zeros(11, bool))


def test_TimesThatFall_AreNamedWithTheirPlace(damaged):
    times, ma, slo = (array.copy() for array in edges_of(damaged))
    for place in (5, 40_000, len(times) - 1):
        wrong = times.copy()
        wrong[place] = wrong[0] - 1
        with pytest.raises(biss.CaptureError, match=f"element {place + 1}: time runs backwards"):
            biss.decode(biss.Capture.edges(wrong, ma, slo), format=FORMAT)


def test_HugeTimes_AreRead(damaged):
    most = np.iinfo(np.int64).max
    times, ma, slo = edges_of(damaged)
    late = times - times[-1] + most
    columns = biss.decode(biss.Capture.edges(late, ma, slo), format=FORMAT)
    assert columns.rows == biss.decode(damaged, format=FORMAT).rows
    early = times - times[0] + np.iinfo(np.int64).min
    assert biss.decode(biss.Capture.edges(early, ma, slo), format=FORMAT).rows == columns.rows


@pytest.mark.parametrize("rate", [0, -1, 1 << 32, 1 << 70, 1.5, "100MHz", None, np.nan, True])
def test_WrongRate_IsNamed(rate):
    with pytest.raises((TypeError, ValueError)):
        biss.decode(np.zeros(10, np.uint8), sample_rate=rate)


def test_WrongCaptures_AreNamed(tmp_path):
    with pytest.raises(biss.CaptureError, match="cannot be opened"):
        biss.decode(tmp_path / "nothing.vcd")
    with pytest.raises(biss.CaptureError, match="is a folder"):
        biss.decode(tmp_path)
    (tmp_path / "x.vcd").write_bytes(b"\x00\xff" * 100)
    with pytest.raises(biss.CaptureError):
        biss.decode(tmp_path / "x.vcd")
    for wrong in (None, 3, [1, 2], b"file.vcd", object()):
        with pytest.raises(TypeError):
            biss.decode(wrong)
    with pytest.raises(biss.UsageError):
        biss.decode("a\0b")
    with pytest.raises(biss.CaptureError):
        biss.decode("--help")
    with pytest.raises(TypeError):
        biss.Capture.content("text")
    with pytest.raises(biss.CaptureError):
        biss.decode(biss.Capture.content(b""))
    with pytest.raises(OSError):
        biss.decode(tmp_path / "nothing.vcd")


def test_NoFileLeft_AVerbStillPrints():
    script = ("import biss, resource\n"
              "resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))\n"
              "print(len(biss.run('encoders', to='csv').output.splitlines()))\n")
    done = subprocess.run(["/usr/bin/python3", "-c", script], capture_output=True, check=True)
    assert int(done.stdout) > 10


def test_TwoThreads_GetWhatOneGets(tmp_path):
    files = [str(tmp_path / name) for name in ("a.vcd", "b.vcd")]
    for number, file in enumerate(files):
        biss.run("simulate", format="resolute-26", cycles=300 + number, fault="flip:0.01",
                 seed=number, output=file)

    def decode(file):
        result = biss.run("decode", file, format="resolute-26", to="csv")
        return result.output, result.summary

    alone = [decode(file) for file in files]
    assert alone[0] != alone[1]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        both = [list(pool.map(decode, files)) for _ in range(20)]
    assert all(each == alone for each in both)



@pytest.fixture
def interrupted():
    """Interrupts this thread soon. A run that does not end is ended with the process."""
    faulthandler.dump_traceback_later(120, exit=True)
    # A process that a shell has started in the background ignores SIGINT.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    yield timer
    timer.cancel()
    timer.join()
    signal.signal(signal.SIGINT, handler)
    faulthandler.cancel_dump_traceback_later()


@pytest.mark.parametrize("run", [
    lambda capture: biss.decode(*[capture] * 1000, format=FORMAT),
    lambda capture: biss.decode(*[capture] * 1000, format=FORMAT, every=10**6, threads=1),
    lambda capture: biss.check(*[capture] * 1000, against="renishaw"),
    lambda capture: biss.run("decode", *[capture] * 1000, format=FORMAT, to="csv",
                             output="/dev/null"),
    lambda capture: biss.simulate(FORMAT, cycles=10**8),
    lambda capture: biss.records("safety campaign", format="fs-36-28", frames=10**12),
], ids=["decode", "few_rows", "check", "csv", "simulate", "campaign"])
def test_Interrupt_EndsARun(damaged, interrupted, run):
    times, ma, slo = edges_of(damaged)
    span = int(times[-1] - times[0]) + 10**9
    many = np.concatenate([times + i * span for i in range(50)])
    capture = biss.Capture.edges(many, np.tile(ma, 50), np.tile(slo, 50))
    interrupted.start()
    with pytest.raises(KeyboardInterrupt):
        run(capture)
    assert biss.decode(damaged, format=FORMAT).rows == 3000


def test_WrongOptions_HaveTheTextOfTheCommand(damaged):
    with pytest.raises(biss.UsageError, match="unknown option '--colums'; did you mean '--columns'"):
        biss.decode(damaged, colums="x")
    with pytest.raises(biss.UsageError, match="'nothing' is not one of cycle, time_ns"):
        biss.decode(damaged, columns="nothing")
    for name, value in (("output", "rows.csv"), ("fail_on", "any"), ("help", True)):
        with pytest.raises(biss.UsageError, match=name):
            biss.decode(damaged, **{name: value})
    with pytest.raises(biss.UsageError):
        biss.decode(damaged, format="")
    with pytest.raises(TypeError):
        biss.decode(damaged, threads=object())
    with pytest.raises(biss.UsageError):
        biss.decode(damaged, format="pos\0")
    with pytest.raises(biss.UsageError, match="unknown verb"):
        biss.run("nothing")
    with pytest.raises(biss.UsageError):
        biss.run("view", damaged)
    with pytest.raises(ValueError):
        biss.decode(damaged, format="x" * 10_000)


def test_RandomBytes_EndWithRowsOrANamedError(damaged, sampled):
    random.seed(16)
    content = damaged.read_bytes()[:20_000]
    for _ in range(300):
        data = bytearray(content if random.random() < 0.7 else random.randbytes(2000))
        for _ in range(random.choice([1, 5, 100])):
            data[random.randrange(len(data))] = random.randrange(256)
        del data[random.randrange(len(data)):]
        try:
            name = random.choice(["x.csv", "x.vcd", "x.sr", "x.bin", "x"])
            columns = biss.decode(biss.Capture.content(bytes(data), name),
                                  format=random.choice([None, FORMAT, "none"]))
        except biss.Error as error:
            assert str(error)
            continue
        assert columns.rows >= 0
    for _ in range(100):
        samples = sampled[:20_000].copy()
        places = np.array([random.randrange(len(samples)) for _ in range(random.choice([1, 500]))])
        samples[places] = np.frombuffer(random.randbytes(len(places)), np.uint8)
        try:
            biss.decode(samples, sample_rate=random.choice([1, RATE, (1 << 32) - 1]), format=FORMAT)
        except biss.Error as error:
            assert str(error)
