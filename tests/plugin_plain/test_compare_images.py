# SPDX-License-Identifier: GPL-3.0-or-later
"""Two renders are compared bit for bit; only what surely is a tie between objects present in both is let off."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules.compare_images import (
    ImageError,
    channel,
    compare,
    index_channel,
    read_layers,
    side_by_side,
    write_png,
)


def picture(index, depth):
    index, depth = np.array(index, np.float32), np.array(depth, np.float32)
    layers = {f"ViewLayer.Combined.{c}": np.full(index.shape, 0.5, np.float32) for c in "RGBA"}
    return {**layers, "ViewLayer.Depth.Z": depth, "ViewLayer.IndexOB.X": index}


WHOLE = picture([[1, 2], [3, 0]], [[1.0, 2.0], [3.0, 1e10]])


def test_equal_pictures_are_equal():
    found = compare(WHOLE, WHOLE)
    assert found.equal and found.index_different == found.depth_different == 0 and found.beauty_rms == 0.0


def test_one_bit_of_depth_counts():
    other = picture([[1, 2], [3, 0]], [[np.nextafter(np.float32(1), np.float32(2)), 2.0], [3.0, 1e10]])
    assert compare(WHOLE, other).depth_wrong == 1 and not compare(WHOLE, other).equal


def test_a_tie_needs_both_objects_in_both_renders_and_one_place():
    swapped = picture([[2, 2], [3, 0]], [[1.0 + 2e-6, 2.0], [3.0, 1e10]])
    assert compare(WHOLE, swapped, {1, 2, 3}).equal
    assert compare(WHOLE, swapped, {1, 2, 3}).ties == 1 and compare(WHOLE, swapped, {1, 2, 3}).index_different == 1
    assert compare(WHOLE, swapped, {2, 3}).index_wrong == 1  # 1 was hidden: that is no tie
    far = picture([[2, 2], [3, 0]], [[1.1, 2.0], [3.0, 1e10]])
    assert compare(WHOLE, far, {1, 2, 3}).index_wrong == 1


def test_nothing_where_something_was_is_wrong():
    gone = picture([[0, 2], [3, 0]], [[1e10, 2.0], [3.0, 1e10]])
    found = compare(WHOLE, gone, {0, 2, 3})
    assert found.index_wrong == 1 and found.depth_wrong == 1


def test_different_sizes_and_missing_channels_are_errors():
    with pytest.raises(ImageError, match="sizes"):
        compare(WHOLE, picture([[1]], [[1.0]]))
    with pytest.raises(ImageError, match="Depth"):
        channel({"a": np.zeros((1, 1))}, "Depth.Z")
    with pytest.raises(ImageError, match="index"):
        index_channel({"a": np.zeros((1, 1))})
    pytest.importorskip("OpenImageIO")
    with pytest.raises(ImageError, match="no-such"):
        read_layers("no-such.exr")


def test_the_comparison_is_written_as_a_picture(tmp_path):
    oiio = pytest.importorskip("OpenImageIO")
    path = tmp_path / "compared.png"
    write_png(str(path), side_by_side(WHOLE, picture([[0, 2], [3, 0]], [[1e10, 2.0], [3.0, 1e10]])))
    pixels = oiio.ImageInput.open(str(path)).read_image("uint8")
    assert pixels.shape == (2, 14, 3)
    assert tuple(pixels[0, 12]) == (255, 0, 0)  # the wrong pixel, red
