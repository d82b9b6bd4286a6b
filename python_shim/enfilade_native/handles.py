# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of the core and who holds them: each is destroyed once, when nothing looks into it any more."""

from __future__ import annotations

from typing import Any, TypeVar

from ._library import library
from .errors import StateError

_Self = TypeVar("_Self", bound="Owned")


class Owner:
    """Holds a handle; destroys it by the library's function of that name when this and every array that looks into it are
    gone. keeps: what has to live as long."""

    __slots__ = ("__weakref__", "_destroy", "handle", "keeps")

    def __init__(self, handle: Any, destroy: str, keeps: object = None) -> None:
        self.handle, self.keeps, self._destroy = handle, keeps, destroy

    def __del__(self) -> None:
        handle, self.handle = self.handle, None
        if handle:
            getattr(library(), self._destroy)(handle)


class Owned:
    """What stands for a handle of the core. Context manager, or close()."""

    closed_message = "this is closed"
    _owner: Owner | None

    @property
    def handle(self) -> Any:
        """The C handle, for the sibling modules. StateError when closed."""
        return self.owner.handle

    @property
    def owner(self) -> Owner:
        """What children (views, jobs, arrays) keep a reference to, so that this outlives them."""
        if self._owner is None:
            raise StateError(self.closed_message)
        return self._owner

    def close(self) -> None:
        """Lets go; again is fine. The memory goes with the last thing that looks into it."""
        self._owner = None

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
