"""Rows as NumPy arrays, a column each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ._errors import UsageError


MaskedArray = np.ma.MaskedArray[Any, Any]
# Has no types.
_ma: Any = np.ma

# They ignore the mask, so the values below it get into results that look normal.
_WITHOUT_MASK = frozenset((np.interp, np.median, np.percentile, np.quantile, np.nanmedian,
                           np.nanpercentile, np.nanquantile))


class MaskedColumn(_ma.MaskedArray):  # type: ignore[misc]
    """A masked array that refuses to use empty cells as positions.

    Functions of NumPy that drop the mask see NaN below it, in integers the number that is farthest
    from all others: 2**63 in uint64, -2**63 in int64, 255 in flags.
    """

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if func in _WITHOUT_MASK and any(_ma.is_masked(each) for each in (*args, *kwargs.values())):
            raise UsageError(f"{func.__name__}() ignores the mask of values that were not received; "
                             "choose rows first, as with rows.good()")
        return super().__array_function__(func, types, args, kwargs)

    def __array_wrap__(self, obj: Any, context: Any = None, **more: Any) -> Any:
        return _refilled(super().__array_wrap__(obj, context, **more))

    def __sub__(self, other: Any) -> Any:
        return _refilled(super().__sub__(other))

    def astype(self, dtype: Any, order: Any = "K", casting: Any = None, subok: bool = True,
               copy: bool = True) -> Any:
        """Raises UsageError if an empty cell makes floats of integers that floats cannot hold, as
        pandas.DataFrame(dict(rows)) does; ``casting="unsafe"`` rounds them."""
        if (casting is None and self.dtype.kind in "iu" and np.dtype(dtype).kind == "f" and
                _ma.is_masked(self)):
            received = self.compressed().view(np.ndarray)
            if not np.array_equal(received.astype(dtype).astype(np.longdouble), received):
                raise UsageError(f"{np.dtype(dtype)} does not hold all values of this column; "
                                 "rows.to_pandas() has integers with empty cells")
        return _refilled(super().astype(dtype, order, casting or "unsafe", subok, copy))

    def __reduce__(self) -> Any:
        return self.view(_ma.MaskedArray).__reduce__()


class Columns(Mapping[str, MaskedArray]):
    """The rows of ``biss decode``: its columns by name, each a masked array.

    An empty cell of the CSV is masked. The types are:

    * counts, bits and numbers: uint64 (``unwrapped``: int64); flags: uint8, 0 or 1. A position of 64
      bits leaves no number for an empty cell: with such cells it is longdouble, which is as exact
    * times (``time_ns``): float64 in nanoseconds; ``picoseconds()`` has them exactly, as int64
    * ``raw``: uint64, with more than 64 bits rows of uint64 words, the most significant one first;
      the column ``raw_bits`` has the number of bits
    * texts (``status``): str
    """

    def __init__(self, parts: list[tuple[Any, ...]], summary: str, messages: list[str]) -> None:
        self._parts = {part[0]: part for part in parts}
        for name, kind, *_, counts, _, _ in parts:
            if kind == "bits":
                self._parts[name + "_bits"] = (name + "_bits", "unsigned", "", counts, None, [], None, 16,
                                               "value")
        self._made: dict[str, MaskedArray] = {}
        #: The text that the command prints after its rows.
        self.summary: str = summary
        #: Lines that the command prints on stderr, each without ``biss:``.
        self.messages: list[str] = messages
        #: The number of rows; len() is the number of columns.
        self.rows: int = len(parts[0][3]) if parts else 0

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

    def good(self) -> np.ndarray[Any, Any]:
        """A mask of the rows whose position may be used: the status is ``ok``, nE is 1 and the
        checksum is right, in every channel that has them. Safety verdicts do not count.

        Raises UsageError if the columns do not show this.
        """
        channels = ["", *(name[8:] for name in self if name[:8] == "position" and name[8:].isdigit())]
        for name in ("status", *(name for k in channels for name in (f"nE{k}", f"crc{k}_ok"))):
            if name not in self:
                raise UsageError(f"good() needs the column {name}; name it in columns too")
        good = np.asarray(self["status"] == "ok")
        for name, *_, role in self._parts.values():
            # Empty in a good frame: the format has no such field.
            if role in ("error_at_0", "check_at_0"):
                good &= _ma.filled(self[name], 1) != 0
        return good

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with integers that are exact and may be empty (UInt64, UInt8, Int64),
        float64 with NaN, and texts of the type string. Words of ``raw`` with more than 64 bits are int.

        The index is ``time_ns`` rounded to a nanosecond. Needs pandas (package python3-pandas).
        """
        import pandas  # type: ignore[import]

        table: dict[str, Any] = {}
        for name, (_, kind, _, values, absent, *_) in self._parts.items():
            mask = np.zeros(self.rows, bool) if absent is None else absent.astype(bool)
            if kind in ("time", "real"):
                table[name] = np.asarray(self[name])
            elif kind == "text":
                table[name] = pandas.array(_ma.filled(self[name].astype(object), pandas.NA), "string")
            elif values.ndim == 2:
                words = [int.from_bytes(row.astype(">u8").tobytes(), "big") for row in values]
                table[name] = pandas.Series(words, dtype=object).mask(mask, pandas.NA).array
            else:
                table[name] = pandas.arrays.IntegerArray(values.copy(), mask)
        index = None
        if "time_ns" in self._parts:
            rounded = (np.asarray(self.picoseconds()) + 500) // 1000
            index = pandas.Index(rounded.astype("timedelta64[ns]"), name="time")
        return pandas.DataFrame(table, index)

    def __getitem__(self, name: str) -> MaskedArray:
        if name not in self._made:
            self._made[name] = self._make(self._parts[name])
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def __repr__(self) -> str:
        return f"<biss.Columns: {self.rows} rows of {', '.join(self._parts)}>"

    @staticmethod
    def _make(part: tuple[Any, ...]) -> MaskedArray:
        _, kind, _, values, absent, texts, _, bits, _ = part
        if kind == "time":
            values = values / 1000.0
        elif kind == "text":
            values = np.array(texts if texts else [""], dtype=np.str_)[values.astype(np.intp)]
        elif kind == "bits" and absent is not None and values.ndim == 2:
            absent = np.repeat(absent[:, np.newaxis], values.shape[1], axis=1)
        # The first bit of `raw` is 1, so that it is never 0.
        return masked(values, absent, bits, 0 if kind == "bits" else None)


def _refilled(array: Any) -> Any:
    if isinstance(array, MaskedColumn) and _ma.is_masked(array) and array.dtype.kind in "biuf":
        array._data[array._mask] = array.fill_value = absent_value(array.dtype)
    return array


def absent_value(dtype: Any) -> Any:
    """The value below the mask, unlikely as a real value; None for texts."""
    if dtype == np.uint8:
        return 255
    top = 1 << (8 * dtype.itemsize - 1)
    return {"f": np.nan, "b": False, "u": top, "i": -top}.get(dtype.kind)


def masked(values: np.ndarray[Any, Any], absent: np.ndarray[Any, Any] | None = None, bits: int = 0,
           fill: int | None = None) -> MaskedArray:
    """Masks the values for which `absent` is true; the widest value has `bits` bits."""
    if absent is None:
        return MaskedColumn(values)
    absent = absent.astype(bool)
    if bits == 64 and fill is None and absent.any():
        values = values.astype(np.longdouble)
    fill = absent_value(values.dtype) if fill is None else fill
    if fill is not None:
        values = np.where(absent, np.array(fill, values.dtype), values)
    return MaskedColumn(values, absent, fill_value=fill)
