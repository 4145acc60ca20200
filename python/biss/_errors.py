"""The exceptions of the package. Each has the text that the command prints."""

from __future__ import annotations

from typing import Any


class Error(Exception):
    """Something of this package has failed.

    ``messages`` has every line that the command prints, the last one of which is the text.
    """

    def __init__(self, text: str, messages: list[str] | None = None) -> None:
        super().__init__(text)
        self.messages: list[str] = messages if messages is not None else [text]


class UsageError(Error, ValueError):
    """An argument is wrong; nothing was read or written. The command's exit status 2."""


class CaptureError(Error, OSError):
    """A file or array cannot be read or is malformed, or a file cannot be written. Status 3."""


class DataError(Error):
    """The data do not have the requested content, for example a request cycle. The command's exit
    status 1."""


class FrameError(DataError):
    """The bits are not a frame. ``cause`` is the status that ``decode`` gives such a row."""

    def __init__(self, text: str, cause: str, channel: int = 0) -> None:
        super().__init__(text)
        self.cause: str = cause
        self.channel: int = channel

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.cause, self.channel), self.__dict__


_CLASSES: dict[int, type[Error]] = {1: DataError, 2: UsageError, 3: CaptureError}


def error_of(status: int, messages: list[str]) -> Error:
    """The exception of an exit status of the command."""
    text = messages[-1] if messages else f"failed with status {status}"
    return _CLASSES.get(status, Error)(text, messages)
