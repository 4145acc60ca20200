"""Read, simulate and judge encoders with the BiSS C interface.

The verbs of the command ``biss`` as functions (``decode``, ``check``, ``explain``, …), on files and on
NumPy arrays; a decoder for a capture that is still running (``Decoder``); frames and SPI buffers
(``Format``, ``SpiReader``). docs/python.md of the project describes all of it.
"""

from __future__ import annotations

from ._columns import Columns
from ._core import version as __version__
from ._errors import CaptureError, DataError, Error, FrameError, UsageError
from ._frames import Bits, Channel, Format, Frame, SpiColumns, SpiReader, crc
from ._stream import Decoder, Field, Row
from ._verbs import (Capture, Result, Simulation, check, compare, decode, draw, eds, encoders,
                     explain, identify, plan, records, registers, run, safety_analysis, simulate)

__all__ = [
    "Bits", "Capture", "CaptureError", "Channel", "Columns", "DataError", "Decoder", "Error",
    "Field", "Format", "Frame", "FrameError", "Result", "Row", "Simulation", "SpiColumns", "SpiReader",
    "UsageError", "__version__", "check", "compare", "crc", "decode", "draw", "eds", "encoders",
    "explain", "identify", "plan", "records", "registers", "run", "safety_analysis", "simulate",
]
