# SPDX-License-Identifier: GPL-3.0-or-later
"""Numpy arrays across the border: checked on the way in, views without a copy on the way out."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from .errors import InvalidArgumentError


class Rows:
    """An array on its way into C: `address`, `count` rows, `stride` bytes between them. Keep it until the call returns."""

    __slots__ = ("address", "array", "count", "stride")

    def __init__(self, value: Any, columns: int, what: str, dtype: Any = np.float64) -> None:
        """value: (n, columns) of `dtype`, or what numpy can turn into it. Copied only when the dtype differs or a row
        isn't contiguous; rows may lie apart (a strided view goes through as it is)."""
        try:
            array = np.asarray(value, dtype=dtype)
        except (TypeError, ValueError) as error:
            raise InvalidArgumentError(f"{what}: no array of {np.dtype(dtype).name}: {error}") from None
        if array.size == 0:
            array = array.reshape(0, columns)
        if array.ndim != 2 or array.shape[1] != columns:
            raise InvalidArgumentError(f"{what}: shape {array.shape}, wanted (n, {columns})")
        if array.shape[0] and (array.strides[1] != array.itemsize or array.strides[0] <= 0):
            array = np.ascontiguousarray(array)
        self.array = array
        self.count = array.shape[0]
        self.stride = array.strides[0] if self.count > 1 else columns * array.itemsize
        self.address = array.ctypes.data if self.count else None


class Flat:
    """A one-dimensional array on its way into C, C-contiguous: `address` and `count`."""

    __slots__ = ("address", "array", "count")

    def __init__(self, value: Any, what: str, dtype: Any, count: int | None = None) -> None:
        try:
            source = np.asarray(value)
            if source.size and np.dtype(dtype).kind == "u":
                # A cast from a negative or a too large number would wrap in silence and name some other item.
                if source.dtype.kind not in "iub" or int(source.min()) < 0 or int(source.max()) > np.iinfo(dtype).max:
                    raise InvalidArgumentError(f"{what}: wanted whole numbers from 0 to {np.iinfo(dtype).max}")
            array = np.ascontiguousarray(source, dtype=dtype).reshape(-1)
        except (TypeError, ValueError) as error:
            if isinstance(error, InvalidArgumentError):
                raise
            raise InvalidArgumentError(f"{what}: no array of {np.dtype(dtype).name}: {error}") from None
        if count is not None and array.size != count:
            raise InvalidArgumentError(f"{what}: {array.size} numbers, wanted {count}")
        self.array = array
        self.count = array.size
        self.address = array.ctypes.data if array.size else None


def faces_flat(faces: Sequence[Sequence[int]] | None, what: str) -> tuple[Flat, Flat]:
    """Faces as (sizes, indices in turn), both uint32; None is no faces."""
    if faces is None:
        faces = ()
    if isinstance(faces, np.ndarray) and faces.ndim == 2:
        sizes = np.full(faces.shape[0], faces.shape[1], dtype=np.uint32)
        return Flat(sizes, what, np.uint32), Flat(faces, what, np.uint32)
    sizes = [len(face) for face in faces]
    indices = [index for face in faces for index in face]
    return Flat(sizes, f"{what} sizes", np.uint32), Flat(indices, f"{what} indices", np.uint32)


class View:
    """Memory of a library object, for numpy: keeps `owner` alive as long as an array looks at it."""

    __slots__ = ("__array_interface__", "__weakref__", "owner")

    def __init__(self, owner: object, address: int, shape: tuple[int, ...], dtype: Any) -> None:
        self.owner = owner
        self.__array_interface__ = {
            "data": (address, True),  # read-only
            "shape": shape,
            "typestr": np.dtype(dtype).str,
            "version": 3,
        }


def address_of(pointer: Any) -> int:
    """The number behind a ctypes pointer, 0 for NULL."""
    return ctypes.cast(pointer, ctypes.c_void_p).value or 0
