"""10^5 calls leave the memory as it was."""

import os

import numpy as np
import pytest

import biss
from conftest import FORMAT, edges_of

CALLS = int(os.environ.get("BISS_LEAK_CALLS", "100000"))


def resident_bytes():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def grown(call, calls):
    """Bytes by which the process grows from the first tenth of the calls to the last one."""
    for _ in range(calls // 10):
        call()
    before = resident_bytes()
    for _ in range(calls - calls // 10):
        call()
    return resident_bytes() - before


def test_ManyCalls_DoNotGrow(damaged):
    times, ma, slo = (array[:400] for array in edges_of(damaged))
    capture = biss.Capture.edges(times, ma, slo)
    format = biss.Format(FORMAT)
    bits = format.encode(1234)

    def stream():
        decoder = biss.Decoder(FORMAT, fields=True)
        decoder.edges(times, ma, slo)
        assert decoder.finish()

    def wrong():
        with pytest.raises(biss.UsageError):
            biss.Format("pos99")
        with pytest.raises(TypeError):
            biss.decode(np.zeros(3), sample_rate=1)

    for call, share in ((lambda: biss.decode(capture, format=FORMAT)["position"], 10),
                        (stream, 10), (lambda: format.decode(bits), 1), (wrong, 10),
                        (lambda: biss.Format(FORMAT), 1)):
        assert grown(call, CALLS // share) < 2 << 20
