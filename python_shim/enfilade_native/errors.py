# SPDX-License-Identifier: GPL-3.0-or-later
"""What can go wrong, as exceptions: one kind per EnfStatus, and LibraryError when there is no library to ask."""

from __future__ import annotations


class EnfError(Exception):
    """A call failed. `status` is the EnfStatus, the text is the library's own sentence with index and reason."""

    status = -1

    def __init__(self, message: str, status: int | None = None) -> None:
        super().__init__(message)
        if status is not None:
            self.status = status


class InvalidArgumentError(EnfError, ValueError):
    """The caller's code is wrong: an index out of range, a wrong shape."""

    status = 1


class BadInputError(EnfError, ValueError):
    """The data is wrong: NaN, a dangling reference, a truncated file."""

    status = 2


class EnfIOError(EnfError, OSError):
    """A file can't be opened, read or written."""

    status = 3


class EnfMemoryError(EnfError, MemoryError):
    status = 4


class CancelledError(EnfError):
    """The job was cancelled by its owner."""

    status = 5


class StateError(EnfError, RuntimeError):
    """Right call, wrong moment: a query before commit, an edit while views of the arrays are held."""

    status = 6


class InternalError(EnfError, RuntimeError):
    """A bug of the library."""

    status = 7


class LibraryError(ImportError):
    """The C library is missing, can't be loaded, or is of another build than this package."""


KINDS: dict[int, type[EnfError]] = {
    kind.status: kind
    for kind in (
        InvalidArgumentError,
        BadInputError,
        EnfIOError,
        EnfMemoryError,
        CancelledError,
        StateError,
        InternalError,
    )
}


def error_for(status: int, message: str) -> EnfError:
    """The exception that stands for a failed status."""
    return KINDS.get(status, EnfError)(message, status)
