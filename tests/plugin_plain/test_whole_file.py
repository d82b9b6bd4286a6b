# SPDX-License-Identifier: GPL-3.0-or-later
"""Files are there whole or not at all."""

from __future__ import annotations

import pytest
from enfilade.rules.whole_file import whole_file


def test_what_was_written_takes_the_place_of_what_was_there(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text("old")
    with whole_file(path) as partial:
        assert partial.parent == tmp_path and partial.suffix == ".svg" and partial != path
        partial.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new" and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("stop", [OSError("no space left"), KeyboardInterrupt()])
def test_what_breaks_off_leaves_what_was_there(tmp_path, stop):
    path = tmp_path / "plan.svg"
    path.write_text("old")
    with pytest.raises(type(stop)), whole_file(path) as partial:
        partial.write_text("half")
        raise stop
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
