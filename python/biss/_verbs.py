"""The verbs of the command as functions."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import dataclass, field
from typing import Any, Union

import numpy as np

from . import _core
from ._columns import Columns
from ._errors import UsageError, error_of
from ._options import given_of, number_of


class Capture:
    """A capture in memory, for every function that takes the path of a file.

    Made by samples() or edges(). The arrays are not copied, so do not change them while a function
    runs.
    """

    def __init__(self, parts: tuple[Any, ...]) -> None:
        self._parts = parts

    @classmethod
    def samples(cls, samples: np.ndarray[Any, Any], sample_rate: int) -> Capture:
        """Samples of all lines: uint8, uint16, uint32 or uint64, contiguous.

        Bit k is the line ``Dk``, as in a raw file; name lines with ``ma="D0"`` and ``slo="D1"``.
        """
        if not (isinstance(samples, np.ndarray) and samples.dtype.kind == "u" and
                samples.dtype.isnative):
            raise TypeError("samples: an array of uint8, uint16, uint32 or uint64 is needed")
        rate = number_of(sample_rate, "sample_rate")
        if not 1 <= rate < 1 << 32:
            raise UsageError("sample_rate: from 1 to 4294967295 Hz")
        return cls((samples, rate))

    @classmethod
    def edges(cls, times_ps: np.ndarray[Any, Any], ma: np.ndarray[Any, Any],
              slo: np.ndarray[Any, Any], *, resolution_ps: int = 0) -> Capture:
        """Edges: from each time on, in picoseconds (int64, never falling), MA and SLO have these
        levels (bool or uint8). ``resolution_ps`` is the period of the samples that they come from.
        """
        for name, array in (("times_ps", times_ps), ("ma", ma), ("slo", slo)):
            if not isinstance(array, np.ndarray):
                raise TypeError(f"{name}: a NumPy array is needed, not {type(array).__name__}")
        period = number_of(resolution_ps, "resolution_ps")
        if not 0 <= period < 1 << 62:
            raise UsageError("resolution_ps: not negative")
        return cls((times_ps, ma, slo, period))

    @classmethod
    def content(cls, data: bytes, name: str = "capture") -> Capture:
        """The content of a file of any format; only the extension of ``name`` matters."""
        if not isinstance(data, bytes):
            raise TypeError(f"data: bytes are needed, not {type(data).__name__}")
        return cls((data, os.fspath(name), None))

    @classmethod
    def load(cls, capture: Source, *more: Source, sample_rate: int | None = None,
             **options: Any) -> Capture:
        """The edges of MA and SLO in a file: edges(), with the arrays in ``arrays``.

        ``ma`` and ``slo`` name the lines; an inverted line is inverted back. ``options`` are the
        options of ``biss decode``. Raises CaptureError and UsageError, and DataError if no lines
        look like MA and SLO.
        """
        words, given = _sources((capture, *more), sample_rate)
        status, messages, period, *arrays = _core.edges(
            ["decode", *words], given_of(options), given)
        if status != 0:
            raise error_of(status, messages)
        return cls((*arrays, period))

    @property
    def arrays(self) -> tuple[Any, ...]:
        """The arrays of the capture: for edges, ``times_ps``, ``ma`` and ``slo``."""
        return self._parts[:3] if len(self._parts) == 4 else self._parts[:1]


#: A file, or a capture in memory; an array of samples needs ``sample_rate``.
Source = Union[str, "os.PathLike[str]", Capture, np.ndarray]


@dataclass
class Result:
    """The output of a verb of the command."""

    #: The exit status: 0 done, 1 the data failed.
    status: int
    #: The command's standard output.
    output: bytes
    #: The text after that on stderr.
    summary: str
    #: Single lines on stderr, without ``biss:``.
    messages: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The output as text."""
        return self.output.decode("utf-8", "surrogateescape")

    def records(self) -> list[dict[str, Any]]:
        """The output of ``to="jsonl"``: an object a line."""
        return [json.loads(line) for line in self.output.splitlines() if line.strip()]


def _path_of(path: str | os.PathLike[str]) -> str:
    text = os.fspath(path)
    if not isinstance(text, str):
        raise TypeError("a path is a str, not bytes")
    if "\0" in text:
        raise UsageError("a path has no NUL character")
    return os.path.join(".", text) if text.startswith("-") and text != "-" else text


def _sources(captures: tuple[Any, ...],
             sample_rate: Any) -> tuple[list[str], dict[str, tuple[Any, ...]]]:
    words: list[str] = []
    given: dict[str, tuple[Any, ...]] = {}
    if sample_rate is not None and not any(isinstance(each, np.ndarray) for each in captures):
        raise UsageError("sample_rate: only for an array; for a file of raw samples use raw_rate")
    for capture in captures:
        if isinstance(capture, np.ndarray):
            if sample_rate is None:
                raise TypeError("an array of samples needs sample_rate")
            capture = Capture.samples(capture, sample_rate)
        if isinstance(capture, Capture):
            name = "array" if len(captures) == 1 else f"array {len(given) + 1}"
            given[name] = capture._parts
            words.append(name)
        elif isinstance(capture, (str, os.PathLike)):
            words.append(_path_of(capture))
        else:
            raise TypeError(f"a path, a Capture or an array is needed, not {type(capture).__name__}")
    return words, given


def _run(verb: str, words: list[str], given: dict[str, tuple[Any, ...]], options: dict[str, Any],
         keep: bool = False) -> tuple[Result, list[tuple[Any, ...]]]:
    for word in words:
        if "\0" in word:
            raise UsageError("an argument has no NUL character")
    status, output, summary, messages, columns = _core.run(
        [*verb.split(), *words], given_of(options), given, keep)
    if status >= 2:
        raise error_of(status, messages)
    return Result(status, output, summary, messages), columns


def _run_on(verb: str, arguments: tuple[Any, ...], options: dict[str, Any]) -> Result:
    if not arguments:
        return _run(verb, [], {}, options)[0]
    words, given = _sources(arguments, options.pop("sample_rate", None))
    return _run(verb, words, given, options)[0]


def run(verb: str, *arguments: Source, sample_rate: int | str | None = None,
        **options: Any) -> Result:
    """Runs a verb of the command in this process: ``run("safety analyse", format="rsm")``.

    ``arguments`` are words of the command line; if the verb reads a capture, a Capture or an array
    of samples (with ``sample_rate``) takes the place of a file. Without any argument ``sample_rate`` is the
    option of that name, which ``simulate`` has. An option has the name of the command with
    underscores; True gives it without a value, a list repeats it. Every verb but ``view`` is there.

    Raises UsageError if the command's exit status is 2, and CaptureError if it is 3. Status 1, the
    data failed, is in the result.
    """
    return _run_on(verb, arguments, {**options, "sample_rate": sample_rate})


def records(verb: str, *arguments: Source, sample_rate: int | str | None = None,
            **options: Any) -> list[dict[str, Any]]:
    """The rows of a verb that has ``--to jsonl``, as dictionaries: ``records("encoders")``.

    Integers above 2**53 are texts, as in the command's JSON. Raises DataError if there is no row
    because the data failed.
    """
    result = _run_on(verb, arguments, {**options, "sample_rate": sample_rate, "to": "jsonl"})
    if result.status == 1 and not result.output and result.messages:
        raise error_of(1, result.messages)
    return result.records()


def decode(capture: Source, *more: Source, format: str | None = None,
           sample_rate: int | None = None, **options: Any) -> Columns:
    """Reads the positions in a capture: a row for each request cycle, as ``biss decode``.

    ``capture`` is the path of a file, a Capture, or an array of samples with ``sample_rate``. Without
    ``format`` it is identified from the frames. ``options`` are the options of ``biss decode``:
    ``only_errors=True``, ``columns="time_ns,position"``, ``safety="rsm"``, ``threads=2``.

    Raises UsageError, CaptureError, and DataError if there is no request cycle.
    """
    for name in ("to", "output", "fail_on", "help"):
        if options.get(name) is not None:
            raise UsageError(f"{name}: not for columns in memory; use biss.run()")
    words, given = _sources((capture, *more), sample_rate)
    result, parts = _run("decode", words, given, {"format": format, **options}, keep=True)
    if result.status == 1:
        raise error_of(1, result.messages)
    return Columns(parts, result.summary, result.messages)


def identify(capture: Source, *more: Source, **options: Any) -> list[dict[str, Any]]:
    """Identifies protocol and frame format of an unknown line, as ``biss identify --to jsonl``."""
    return records("identify", capture, *more, **options)


def check(capture: Source, *more: Source, against: str = "biss-c",
          **options: Any) -> list[dict[str, Any]]:
    """Compares a capture with the rules of a device or of BiSS C, as ``biss check --to jsonl``."""
    return records("check", capture, *more, against=against, **options)


def explain(capture: Source, *more: Source, format: str | None = None,
            **options: Any) -> list[dict[str, Any]]:
    """Why a link does not work: causes with their likelihood, evidence and remedy."""
    return records("explain", capture, *more, format=format, **options)


def registers(capture: Source, *more: Source, **options: Any) -> list[dict[str, Any]]:
    """Register accesses and commands that a capture shows, as ``biss registers --to jsonl``."""
    return records("registers", capture, *more, **options)


def compare(good: Source, bad: Source, **options: Any) -> list[dict[str, Any]]:
    """The differences between two captures of a link, as ``biss compare --to jsonl``."""
    return records("compare", good, bad, **options)


@dataclass
class Simulation:
    """A simulated capture."""

    #: The lines at the master.
    capture: Capture
    #: The positions sent and the faults: a row for each request cycle, as texts.
    truth: list[dict[str, str]]
    #: The text of the command on stderr.
    summary: str
    messages: list[str]


def simulate(format: str | None = None, **options: Any) -> Simulation:
    """Simulates a master that reads an encoder, as ``biss simulate``.

    ``simulate("resolute-26", cycles=1000, fault=["flip:0.01", "cut@40,bit=5"], seed=7)``
    """
    for name in ("output", "truth", "to"):
        if name in options:
            raise UsageError(f"{name}: the result is in memory; use biss.run() to write files")
    truth = os.memfd_create("truth")
    try:
        result, _ = _run("simulate", [], {}, {"format": format, "output": "-",
                                               "truth": f"/dev/fd/{truth}", **options})
        with open(truth, encoding="utf-8", newline="", closefd=False) as file:
            file.seek(0)
            rows = list(csv.DictReader(file))
    finally:
        os.close(truth)
    capture = Capture.load(Capture.content(result.output, "line.vcd"), ma="MA", slo="SLO")
    return Simulation(capture, rows, result.summary, result.messages)


def draw(capture: Source, *, cycle: int, svg: bool = False, **options: Any) -> str:
    """A request cycle as a drawing: text, or SVG.

    Raises DataError if the capture has no such request cycle.
    """
    result = _run_on("draw", (capture,), {"cycle": cycle, "to": "svg" if svg else "text", **options})
    if result.status == 1:
        raise error_of(1, result.messages)
    return result.text


def encoders(*names: str, **options: Any) -> list[dict[str, Any]]:
    """The encoders of the catalogue, or the data of some, as ``biss encoders --to jsonl``."""
    return records("encoders", *names, **options)


def plan(format: str, **options: Any) -> list[dict[str, Any]]:
    """Which clock and request rate a link allows, as ``biss plan --to jsonl``."""
    return records("plan", format=format, **options)


def eds(path: str | os.PathLike[str], *more: str | os.PathLike[str],
        **options: Any) -> list[dict[str, Any]]:
    """The electronic data sheet in a dump of registers, as ``biss eds show --to jsonl``."""
    return records("eds show", path, *more, **options)


def safety_analysis(format: str, **options: Any) -> list[dict[str, Any]]:
    """Strength of the checks of a safety format, as ``biss safety analyse --to jsonl``."""
    return records("safety analyse", format=format, **options)
