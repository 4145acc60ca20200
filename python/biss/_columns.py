"""Rows as NumPy arrays, a column each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np


MaskedArray = np.ma.MaskedArray[Any, Any]


class Columns(Mapping[str, MaskedArray]):
    """The rows of ``biss decode``: its columns by name, each a masked array.

    An empty cell of the CSV is masked. The types are:

    * counts, bits and numbers: uint64 (``unwrapped``: int64); flags: uint8, 0 or 1
    * times (``time_ns``): float64 in nanoseconds; ``picoseconds()`` has them exactly, as int64
    * ``raw``: uint64, with more than 64 bits rows of uint64 words, the most significant one first;
      the column ``raw_bits`` has the number of bits
    * texts (``status``): str
    """

    def __init__(self, parts: list[tuple[Any, ...]], *, format: str | None = None,
                 summary: str = "", messages: list[str] | None = None) -> None:
        self._parts = {part[0]: part for part in parts}
        for name, kind, *_, counts in parts:
            if kind == "bits":
                self._parts[name + "_bits"] = (name + "_bits", "unsigned", "", counts, None, [], None)
        self._made: dict[str, MaskedArray] = {}
        #: What the command prints after its rows.
        self.summary: str = summary
        #: Lines that the command prints on stderr, each without ``biss:``.
        self.messages: list[str] = messages if messages is not None else []
        self._rows: int = len(parts[0][3]) if parts else 0

    @property
    def rows(self) -> int:
        """The number of rows; len() is that of the columns."""
        return self._rows

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one."""
        return {name: part[2] for name, part in self._parts.items() if part[2]}

    def picoseconds(self, name: str = "time_ns") -> MaskedArray:
        """A column of times as int64 in picoseconds, exact."""
        part = self._parts[name]
        if part[1] != "time":
            raise KeyError(f"{name} is not a column of times")
        return masked(part[3], part[4])

    def __getitem__(self, name: str) -> MaskedArray:
        if name not in self._made:
            self._made[name] = self._make(self._parts[name])
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def __repr__(self) -> str:
        return f"<biss.Columns: {self._rows} rows of {', '.join(self._parts)}>"

    @staticmethod
    def _make(part: tuple[Any, ...]) -> MaskedArray:
        _, kind, _, values, absent, texts, _ = part
        if kind == "time":
            values = values / 1000.0
        elif kind == "text":
            values = np.array(texts if texts else [""], dtype=np.str_)[values.astype(np.intp)]
        elif kind == "bits" and absent is not None and values.ndim == 2:
            absent = np.repeat(absent[:, np.newaxis], values.shape[1], axis=1)
        return masked(values, absent)


def masked(values: np.ndarray[Any, Any],
           absent: np.ndarray[Any, Any] | None = None) -> MaskedArray:
    """An array whose values are absent where the other one is true."""
    mask = np.ma.nomask if absent is None else absent
    return np.ma.MaskedArray(values, mask)  # type: ignore[no-untyped-call]
