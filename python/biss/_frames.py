"""Frames: bits, SPI buffers, checksums."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core
from ._columns import MaskedArray, masked
from ._errors import FrameError, UsageError
from ._options import bits_of


@dataclass(frozen=True)
class Channel:
    """The values of a channel of a frame."""

    #: Unsigned; multiturn above singleturn.
    position: int
    #: The sign of life; 0 if the channel has none.
    life_counter: int = 0
    #: False: the encoder reports an error, the position must not be used.
    nE: bool = True
    #: False: the encoder reports a warning.
    nW: bool = True


@dataclass(frozen=True)
class Frame:
    """A frame whose structure and checksums are right."""

    channels: tuple[Channel, ...]
    cds: bool
    #: The bits include STOP.
    stop_seen: bool
    #: Ones before ACK, and zeros of ACK, in clocks of MA.
    lead_clocks: int
    ack_clocks: int
    #: A position without nE, and a channel without CRC, which no setup of a reader has accepted.
    no_error_flag: bool = False
    unchecked: bool = False

    @property
    def position(self) -> int:
        """The position of channel 1."""
        return self.channels[0].position

    @property
    def nE(self) -> bool:
        """nE of channel 1."""
        return self.channels[0].nE

    @property
    def nW(self) -> bool:
        """nW of channel 1."""
        return self.channels[0].nW

    @property
    def trusted(self) -> bool:
        """No channel reports an error, and each has nE and a CRC."""
        missing = self.no_error_flag or self.unchecked
        return not missing and all(channel.nE for channel in self.channels)


@dataclass(frozen=True)
class Bits:
    """Bits in the order on the line, the first one the highest of the first byte."""

    data: bytes
    count: int

    def __str__(self) -> str:
        return bin(int.from_bytes(b"\x01" + self.data, "big"))[3:3 + self.count]


def _bytes(buffer: Any) -> bytes:
    """The bytes of a buffer, or of a sequence of their numbers."""
    if isinstance(buffer, bytes):
        return buffer
    try:
        view = memoryview(buffer)
    except TypeError:
        try:
            return bytes(list(buffer))
        except ValueError:
            raise UsageError("a byte is from 0 to 255") from None
        except TypeError:
            raise TypeError(f"bytes are needed, not {type(buffer).__name__}") from None
    if view.itemsize != 1 or view.format == "?":
        raise TypeError(f"bytes are needed, not an array with elements of the type {view.format!r}")
    return view.tobytes()


def _frame(parts: tuple[Any, ...], **missing: bool) -> Frame:
    if parts[0] is not None:
        raise FrameError(parts[0], parts[0], parts[1])
    channels = tuple(Channel(*values) for values in parts[1])
    return Frame(channels, *parts[2:], **missing)


class Format:
    """The meaning of the bits of a frame: the text or the name that ``biss decode -f`` takes.

    The name gives the timing of the device; the options are the same as in the command:
    ``ack_max="16us"``, ``ack_clocks=4``, ``timeout="static:20us"``, ``clock_max="10MHz"``.

    Raises UsageError for a wrong text.
    """

    def __init__(self, format: str, *, ack_max: str | None = None, ack_clocks: int | None = None,
                 timeout: str | None = None, release: int | None = None,
                 clock_max: str | None = None, cycle_min: str | None = None) -> None:
        options = (ack_max, ack_clocks, timeout, release, clock_max, cycle_min)
        self.__setstate__((format, *("" if each is None else str(each) for each in options)))

    def __getstate__(self) -> tuple[str, ...]:
        return self._texts

    def __setstate__(self, texts: tuple[str, ...]) -> None:
        self._texts = texts
        self._format = _core.Format(*texts)
        #: The format in its usual form.
        self.text: str = self._format.text
        #: Bits of all channels with their checksums, without START, CDS and STOP.
        self.payload_bits: int = self._format.payload_bits
        #: Widths and flags of each channel.
        self.channels: list[dict[str, Any]] = self._format.channels
        self._missing = {
            "no_error_flag": any(one["position_bits"] and not one["error"] for one in self.channels),
            "unchecked": any(not one["crc_bits"] for one in self.channels)}

    def __repr__(self) -> str:
        return f"biss.Format({self.text!r})"

    def encode(self, *channels: Channel | int, cds: bool = False, lead_clocks: int = 2,
               ack_clocks: int = 1) -> Bits:
        """Returns the bits of an encoder: SLO once for each clock of MA, from the first to STOP.

        Each channel is a Channel, or its position. Raises UsageError if a value does not fit.
        """
        values = [each if isinstance(each, Channel) else Channel(each) for each in channels]
        return Bits(*self._format.encode(
            [(bits_of(each.position, "position", 64), bits_of(each.life_counter, "life_counter", 32),
              each.nE, each.nW) for each in values], cds, bits_of(lead_clocks, "lead_clocks", 16),
            bits_of(ack_clocks, "ack_clocks", 16)))

    def decode(self, data: Any, *, first_bit: int = 0, bits: int | None = None) -> Frame:
        """Finds and decodes the frame in these bits, which begin with the first clock of MA.

        ``data`` is Bits, bytes or a sequence of their numbers. ACK may have any length that BiSS C
        allows. Raises FrameError with the cause. A frame without nE or CRC has a flag for it, and
        is not trusted.
        """
        first = bits_of(first_bit, "first_bit", 32)
        if bits is not None:
            bits = bits_of(bits, "bits", 32)
        if isinstance(data, Bits):
            if first > data.count:
                raise UsageError(f"first_bit: {first}, but there are {data.count} bits")
            if bits is None:
                bits = data.count - first
            data = data.data
        return _frame(self._format.decode(_bytes(data), first, bits), **self._missing)

    def crc(self, data: int, channel: int = 0) -> int:
        """The checksum of a channel's data bits as it is sent."""
        return self._format.crc(bits_of(data, "data", 64), bits_of(channel, "channel", 3))


class SpiColumns(dict[str, MaskedArray]):
    """The columns of SpiReader.read_all() by name."""

    def good(self) -> np.ndarray[Any, Any]:
        """A mask of the rows whose positions may be used: a frame, and nE is 1 in all channels."""
        without_error = np.all(np.atleast_2d(np.asarray(self["nE"]).T) == 1, axis=0)
        good: np.ndarray[Any, Any] = np.logical_and(self["status"].data == "ok", without_error)
        return good


class SpiReader:
    """Reads frames from the bytes that an SPI peripheral received, MA being its clock.

    ``clock_hz`` is the SPI clock. ``phase`` is the edge of MA at which the peripheral samples:
    ``rising`` (mode 3) or ``falling`` (mode 2). The line delay is from MA to SLO, both at the
    master; the narrower its range, the more wrong frames are detected. ``first_bit`` is the number
    of bits in the buffer before the sample of the first clock.

    A clock above the encoder's limit is refused. So is a position without nE and a channel without
    CRC, unless ``no_error_flag`` or ``unchecked`` states that this is intended.
    """

    def __init__(self, format: Format | str, clock_hz: int, *, phase: str = "rising",
                 line_delay_min_ps: int = 0, line_delay_max_ps: int = 40_000_000,
                 first_bit: int = 0, ignore_tail: bool = False, no_error_flag: bool = False,
                 unchecked: bool = False) -> None:
        if phase not in ("rising", "falling"):
            raise UsageError("phase: rising or falling")
        if not 1 <= clock_hz <= 31_250_000_000:
            raise UsageError("clock_hz: from 1 to 31250000000")
        self.format = format if isinstance(format, Format) else Format(format)
        self._spi = _core.Spi(self.format._format, round(10**12 / clock_hz), phase == "falling",
                              bits_of(line_delay_min_ps, "line_delay_min_ps", 63),
                              bits_of(line_delay_max_ps, "line_delay_max_ps", 63),
                              bits_of(first_bit, "first_bit", 16), ignore_tail, no_error_flag,
                              unchecked)
        #: How many bytes to transfer, for the longest line delay and ACK.
        self.transfer_bytes: int = self._spi.transfer_bytes
        #: The number of clocks of MA that this takes.
        self.clocks: int = self._spi.clocks

    def read(self, buffer: Any, clocks: int | None = None) -> Frame:
        """The frame in a buffer: bytes, an array of them, or a sequence of their numbers, such as
        the list that spidev returns. ``clocks`` is the number of clocks that were sent; by default
        all that are needed. Raises FrameError with the cause."""
        return _frame(self._spi.read(_bytes(buffer), _clocks(clocks)))

    def read_all(self, buffers: np.ndarray[Any, Any], clocks: int | None = None) -> SpiColumns:
        """The frames of an array of uint8 with a buffer in each row.

        Columns: ``status`` (``ok`` or the cause), then ``position``, ``life_counter``, ``nE`` and
        ``nW``, masked if the status is not ok; with several channels, a column for each.
        ``good()`` is the mask of the rows whose positions may be used.
        """
        if not isinstance(buffers, np.ndarray):
            raise TypeError(f"an array of uint8 is needed, not {type(buffers).__name__}")
        causes, *values = self._spi.read_all(buffers, _clocks(clocks))
        names = np.array(_core.statuses, dtype=np.str_)
        bad = causes != 0
        columns = SpiColumns(status=masked(names[causes]))
        widest = max(channel["position_bits"] for channel in self.format.channels)
        for name, array in zip(("position", "life_counter", "nE", "nW"), values):
            bits = widest if name == "position" else 0
            if array.shape[1] == 1:
                columns[name] = masked(array[:, 0], bad, bits)
            else:
                absent = np.repeat(bad[:, np.newaxis], array.shape[1], axis=1)
                columns[name] = masked(array, absent, bits)
        return columns


def _clocks(clocks: int | None) -> int | None:
    return None if clocks is None else bits_of(clocks, "clocks", 32)


def crc(data: int, bits: int, *, width: int = 6, polynomial: int = 0, start: int = 0,
        inverted: bool = True) -> int:
    """The checksum of the lowest ``bits`` bits of ``data``, the highest one first.

    Without ``polynomial`` (full form, 0x43) it is the usual one of this width.
    """
    return _core.crc(bits_of(data, "data", 64), bits_of(bits, "bits", 8), bits_of(width, "width", 8),
                     bits_of(polynomial, "polynomial", 32), bits_of(start, "start", 16), inverted)
