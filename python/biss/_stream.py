"""A decoder that is fed with edges or samples while the capture goes on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from . import _core
from ._errors import UsageError, error_of
from ._options import bits_of, given_of, number_of


class Field(NamedTuple):
    """A stretch of a request cycle on the line.

    The times are the sampling times of SLO, with half a period on each side.
    """

    begin_ps: int
    end_ps: int
    #: ``request``, ``ACK``, ``START``, ``CDS``, a field of the format (``pos``, ``nE``, ``crc``;
    #: from the second channel on with its number, ``pos.2``), ``STOP``, ``timeout``, ``CDM``,
    #: ``line delay``, ``bits`` if no format is known, ``no ACK``.
    name: str
    #: The value of a field or bit that was received whole.
    value: int | None
    #: For a wrong checksum: the right one for the received data.
    expected: int | None
    #: It is not as it should be; an active error or warning of the encoder counts too.
    wrong: bool
    #: ``pos=1234``, ``crc=0x16, expected 0x17``.
    text: str
    #: The same for little room.
    brief: str
    #: ``frame``, or ``delay`` or ``CDM``, which are drawn next to it.
    track: str


class Row(dict[str, Any]):
    """A row of ``biss decode``: its columns by name, None for an empty cell.

    ``time_ns`` and other times are floats in nanoseconds, flags are 0 or 1, ``raw`` is the text.
    """

    __slots__ = ("begin_ps", "end_ps", "_fields")

    def __init__(self, names: list[str], parts: tuple[Any, ...]) -> None:
        values, self.begin_ps, self.end_ps, self._fields = parts
        super().__init__(zip(names, values))

    #: The first edge of MA and the last one, in picoseconds.
    begin_ps: int
    end_ps: int

    @property
    def fields(self) -> list[Field]:
        """The parts of the cycle, in the order of time; empty unless the decoder has
        ``fields=True``."""
        return [Field(*each) for each in self._fields]


class Decoder:
    """``biss decode`` on a capture that comes in piece by piece.

    ``format`` is as for ``biss decode -f``; without it the format is found in the beginning.
    ``options`` are the options of ``biss decode`` with underscores: ``safety="rsm"``,
    ``invert_slo=True``, ``only_errors=True``, ``resolution="10ns"``.

    The rows are the same as from ``biss decode`` on the same capture. The first ones come after
    ``beginning`` edges, because polarity, format and the rate of requests are measured in them; the
    command takes as many as the default. A smaller number gives rows sooner and measures with fewer
    edges.

    Several threads may use a decoder; it does the work of one at a time.

    Raises UsageError for a wrong option.
    """

    def __init__(self, format: str | None = None, *, sample_rate: int = 0, fields: bool = False,
                 beginning: int = 1 << 18, **options: Any) -> None:
        if options.get("help") is not None:
            raise UsageError("help: not for rows in memory; use biss.run()")
        rate = number_of(sample_rate, "sample_rate")
        if not 0 <= rate < 1 << 32:
            raise UsageError("sample_rate: from 1 to 4294967295 Hz")
        edges = number_of(beginning, "beginning")
        if edges < 1:
            raise UsageError("beginning: at least 1 edge")
        self._stream = _core.Stream(given_of({"format": format, **options}), rate, fields,
                                    min(edges, 1 << 24))
        self._check()
        self._names: list[str] = []

    def _check(self) -> None:
        failure = self._stream.failure
        if failure is not None:
            raise error_of(failure[0], [failure[1]])

    def _rows(self, parts: list[tuple[Any, ...]]) -> list[Row]:
        if not parts:
            self._check()
            return []
        if not self._names:
            self._names = [name for name, _ in self._stream.columns]
        return [Row(self._names, each) for each in parts]

    def edges(self, times_ps: Any, ma: Any, slo: Any) -> list[Row]:
        """Takes edges: from each time on, MA and SLO have these levels.

        Either three numbers, or arrays: ``times_ps`` of int64 in picoseconds, which never fall,
        ``ma`` and ``slo`` of bool or uint8. Returns the rows that are finished.
        """
        return self._rows(self._stream.edges(*_arrays(times_ps, "times_ps", ma, slo)))

    def changes(self, numbers: Any, ma: Any, slo: Any) -> list[Row]:
        """The same as edges(), at samples with these numbers; the decoder needs ``sample_rate``."""
        return self._rows(self._stream.changes(*_arrays(numbers, "numbers", ma, slo)))

    def samples(self, samples: Any, *, ma: int = 0, slo: int = 1) -> list[Row]:
        """Takes the next samples: an array of uint8, uint16, uint32 or uint64, and the bits in it.

        The decoder needs ``sample_rate``. Returns the rows that are finished.
        """
        return self._rows(self._stream.samples(_array(samples), bits_of(ma, "ma", 8),
                                               bits_of(slo, "slo", 8)))

    def rows(self) -> list[Row]:
        """Decodes the few edges that wait for more; returns the rows that are finished."""
        return self._rows(self._stream.rows())

    def finish(self, *, end_ps: int | None = None, end_sample: int | None = None) -> list[Row]:
        """The capture ends here, or with its last edge. Returns the last rows.

        Raises DataError if no request cycle was found, as the command does.
        """
        if end_ps is not None:
            end_ps = _int64(end_ps, "end_ps")
        if end_sample is not None:
            end_sample = bits_of(end_sample, "end_sample", 63)
        rows = self._rows(self._stream.finish(end_ps, end_sample))
        if not rows and self._stream.status == 1 and not self._names and self._stream.messages:
            raise error_of(1, self._stream.messages)
        return rows

    def decode(self, chunks: Any) -> Iterator[Row]:
        """The rows of an iterable of arguments of edges(), to its end."""
        for chunk in chunks:
            yield from self.edges(*chunk)
        yield from self.finish()

    @property
    def columns(self) -> list[str]:
        """Names of the columns; empty before the beginning has been read."""
        return [name for name, _ in self._stream.columns]

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one."""
        return {name: unit for name, unit in self._stream.columns if unit}

    @property
    def format(self) -> str | None:
        """The format by which rows are read; None if it is not known."""
        return self._stream.format or None

    @property
    def summary(self) -> str:
        """The text that the command prints after its rows; empty before finish()."""
        return self._stream.summary

    @property
    def messages(self) -> list[str]:
        """Lines that the command prints on stderr."""
        return self._stream.messages


def _int64(value: Any, name: str) -> int:
    number = number_of(value, name)
    if not -(1 << 63) <= number < 1 << 63:
        raise UsageError(f"{name}: {number} does not fit in 64 bits")
    return number


def _arrays(times: Any, name: str, ma: Any, slo: Any) -> tuple[np.ndarray[Any, Any], ...]:
    if np.ndim(times) == 0:
        return np.array([_int64(times, name)]), np.array([bool(ma)]), np.array([bool(slo)])
    return _array(times), _array(ma), _array(slo)


def _array(values: Any) -> np.ndarray[Any, Any]:
    if not isinstance(values, np.ndarray):
        raise TypeError(f"a NumPy array is needed, not {type(values).__name__}")
    return values
