"""Frames: bits, SPI buffers, checksums."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core
from ._columns import MaskedArray, masked
from ._errors import FrameError, UsageError


@dataclass(frozen=True)
class Channel:
    """The values of a channel of a frame."""

    #: Unsigned; multiturn above singleturn.
    position: int
    #: The sign of life; 0 where the channel has none.
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

    @property
    def position(self) -> int:
        """That of channel 1."""
        return self.channels[0].position

    @property
    def nE(self) -> bool:
        """That of channel 1."""
        return self.channels[0].nE

    @property
    def nW(self) -> bool:
        """That of channel 1."""
        return self.channels[0].nW

    @property
    def trusted(self) -> bool:
        """No channel reports an error."""
        return all(channel.nE for channel in self.channels)


@dataclass(frozen=True)
class Bits:
    """Bits in the order on the line, the first one the highest of the first byte."""

    data: bytes
    count: int

    def __str__(self) -> str:
        return bin(int.from_bytes(b"\x01" + self.data, "big"))[3:3 + self.count]


def _check(name: str, value: int, bits: int) -> None:
    if not 0 <= value < 1 << bits:
        raise UsageError(f"{name}: {value} is not from 0 to 2^{bits} - 1")


def _frame(parts: tuple[Any, ...]) -> Frame:
    if parts[0] is not None:
        raise FrameError(parts[0], parts[0], parts[1])
    channels = tuple(Channel(*values) for values in parts[1])
    return Frame(channels, *parts[2:])


class Format:
    """The meaning of the bits of a frame: the text or the name that ``biss decode -f`` takes.

    The timing of the device is that of its name; the options are those of the command:
    ``ack_max="16us"``, ``ack_clocks=4``, ``timeout="static:20us"``, ``clock_max="10MHz"``.

    Raises UsageError for a wrong text.
    """

    def __init__(self, format: str, *, ack_max: str | None = None, ack_clocks: int | None = None,
                 timeout: str | None = None, release: int | None = None,
                 clock_max: str | None = None, cycle_min: str | None = None) -> None:
        def text_of(value: Any) -> str:
            return "" if value is None else str(value)

        try:
            self._format = _core.Format(format, text_of(ack_max), text_of(ack_clocks),
                                        text_of(timeout), text_of(release), text_of(clock_max),
                                        text_of(cycle_min))
        except ValueError as error:
            raise UsageError(str(error)) from None

    @property
    def text(self) -> str:
        """The format in its usual form."""
        return self._format.text

    @property
    def payload_bits(self) -> int:
        """Bits of all channels with their checksums, without START, CDS and STOP."""
        return self._format.payload_bits

    @property
    def channels(self) -> list[dict[str, Any]]:
        """Widths and flags of each channel."""
        return self._format.channels

    def __repr__(self) -> str:
        return f"biss.Format({self.text!r})"

    def encode(self, *channels: Channel | int, cds: bool = False, lead_clocks: int = 2,
               ack_clocks: int = 1) -> Bits:
        """What an encoder sends: SLO once for each clock of MA, from the first one to STOP.

        Each channel is a Channel, or its position. Raises ValueError where a value does not fit.
        """
        values = [each if isinstance(each, Channel) else Channel(each) for each in channels]
        for each in values:
            _check("position", each.position, 64)
            _check("life_counter", each.life_counter, 32)
        _check("lead_clocks", lead_clocks, 16)
        _check("ack_clocks", ack_clocks, 16)
        return Bits(*self._format.encode(
            [(each.position, each.life_counter, each.nE, each.nW) for each in values], cds,
            lead_clocks, ack_clocks))

    def decode(self, data: bytes | Bits, *, first_bit: int = 0, bits: int | None = None) -> Frame:
        """Finds and decodes the frame in these bits, which begin with the first clock of MA.

        ACK may have any length that BiSS C allows. Raises FrameError with the cause.
        """
        _check("first_bit", first_bit, 32)
        if isinstance(data, Bits):
            if bits is None:
                bits = data.count - first_bit
            data = data.data
        return _frame(self._format.decode(bytes(data), first_bit, bits))

    def crc(self, data: int, channel: int = 0) -> int:
        """The checksum of a channel's data bits as it is sent."""
        _check("data", data, 64)
        _check("channel", channel, 3)
        return self._format.crc(data, channel)


class SpiReader:
    """Reads frames from the bytes that an SPI peripheral received, MA being its clock.

    ``clock_hz`` is the SPI clock. ``phase`` is the edge of MA at which the peripheral samples:
    ``rising`` (mode 3) or ``falling`` (mode 2). The line delay is that from MA to SLO, both at the
    master; the narrower its range, the more wrong frames are detected. ``first_bit`` is the number
    of bits in the buffer before the sample of the first clock.
    """

    def __init__(self, format: Format | str, clock_hz: int, *, phase: str = "rising",
                 line_delay_min_ps: int = 0, line_delay_max_ps: int = 40_000_000,
                 first_bit: int = 0, ignore_tail: bool = False) -> None:
        if phase not in ("rising", "falling"):
            raise UsageError("phase: rising or falling")
        if not 1 <= clock_hz <= 31_250_000_000:
            raise UsageError("clock_hz: from 1 to 31250000000")
        _check("first_bit", first_bit, 16)
        _check("line_delay_min_ps", line_delay_min_ps, 63)
        _check("line_delay_max_ps", line_delay_max_ps, 63)
        self.format = format if isinstance(format, Format) else Format(format)
        self._spi = _core.Spi(self.format._format, round(10**12 / clock_hz), phase == "falling",
                              line_delay_min_ps, line_delay_max_ps, first_bit, ignore_tail)

    @property
    def clocks(self) -> int:
        """How many clocks of MA that takes."""
        return self._spi.clocks

    @property
    def transfer_bytes(self) -> int:
        """How many bytes to transfer, for the longest line delay and ACK."""
        return self._spi.transfer_bytes

    def read(self, buffer: Any, clocks: int | None = None) -> Frame:
        """The frame in a buffer. ``clocks`` is the number of clocks that were sent; by default all
        that are needed. Raises FrameError with the cause."""
        return _frame(self._spi.read(memoryview(buffer).tobytes(), clocks))

    def read_all(self, buffers: np.ndarray[Any, Any],
                 clocks: int | None = None) -> dict[str, MaskedArray]:
        """The frames of an array of uint8 with a buffer in each row.

        Columns: ``status`` (``ok`` or the cause), then ``position``, ``life_counter``, ``nE`` and
        ``nW``, masked where the status is not ok; with several channels, a column for each.
        """
        causes, *values = self._spi.read_all(buffers, clocks)
        names = np.array(("ok", *_core.causes), dtype=np.str_)
        bad = causes != 0
        columns = {"status": masked(names[causes])}
        for name, array in zip(("position", "life_counter", "nE", "nW"), values):
            if array.shape[1] == 1:
                columns[name] = masked(array[:, 0], bad)
            else:
                absent = np.repeat(bad[:, np.newaxis], array.shape[1], axis=1)
                columns[name] = masked(array, absent)
        return columns


def crc(data: int, bits: int, *, width: int = 6, polynomial: int = 0, start: int = 0,
        inverted: bool = True) -> int:
    """The checksum of the lowest ``bits`` bits of ``data``, the highest one first.

    Without ``polynomial`` (full form, 0x43) it is the usual one of this width.
    """
    _check("data", data, 64)
    _check("bits", bits, 8)
    _check("width", width, 8)
    _check("polynomial", polynomial, 32)
    _check("start", start, 16)
    return _core.crc(data, bits, width, polynomial, start, inverted)
