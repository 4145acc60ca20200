"""The texts that stand for a device, as tests/devices/check has them for the other faces."""
import pathlib

import pytest

import biss

TEXTS = pathlib.Path(__file__).resolve().parents[2] / "tests/devices/texts.tsv"


def test_EveryText_MeansWhatItMeansInTheCommand():
    for line in TEXTS.read_text(encoding="utf-8").splitlines():
        text, format, ack, timeout = line.split("\t")
        if format == "-":
            with pytest.raises(biss.UsageError):
                biss.Format(text)
            continue
        assert biss.Format(text).text == format, text
        row = biss.plan(text, clock="1MHz")[0]
        assert (row["ack_ns"], row["timeout_ns"]) == (float(ack), float(timeout)), text
