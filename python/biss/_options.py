"""Keywords of Python as options of the command."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from ._errors import UsageError

Option = Any


def number_of(value: Any, name: str) -> int:
    """A whole number of any type, such as one of NumPy."""
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError(f"{name}: a whole number is needed, not {type(value).__name__}")
    return int(value.__index__())


def bits_of(value: Any, name: str, bits: int) -> int:
    """A whole number that fits in this many bits."""
    number = number_of(value, name)
    if not 0 <= number < 1 << bits:
        raise UsageError(f"{name}: {number} is not from 0 to 2^{bits} - 1")
    return number


def text_of(value: Any) -> str:
    """A value of an option as the command reads it."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError(f"an option is a text or a number, not {type(value).__name__}")
    return str(value.__index__())


def given_of(options: dict[str, Option]) -> list[tuple[str, list[str]]]:
    """``clock_max="10MHz"`` as ``--clock-max`` and its values.

    True gives the option alone; False and None leave it out; a list gives it for each of its values.
    """
    given: list[tuple[str, list[str]]] = []
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            given.append((option, []))
            continue
        several = isinstance(value, Iterable) and not isinstance(value, (str, bytes, os.PathLike))
        values = [text_of(each) for each in (value if several else [value])]
        if values:
            given.append((option, values))
    return given
