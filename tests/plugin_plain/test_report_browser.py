# SPDX-License-Identifier: GPL-3.0-or-later
"""The page in a real browser: it opens from disk, draws, says nothing on the console and asks the network for nothing."""

from __future__ import annotations

import os
import shutil
import subprocess

import numpy as np
import pytest
import report_samples as samples
from enfilade.report import html, images, write_report

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")


def browse(page, tmp_path, *options) -> subprocess.CompletedProcess:
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-background-networking",
               "--disable-dev-shm-usage", "--enable-logging=stderr", "--log-level=0", f"--user-data-dir={tmp_path / 'profile'}", *options,
               page.as_uri()]
    # A home of its own: it needs one that can be written.
    return subprocess.run(command, capture_output=True, text=True, timeout=1800, check=False,
                          env={**os.environ, "HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)})


def console(run) -> list[str]:
    return [line for line in run.stderr.splitlines() if "CONSOLE" in line]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    return write_report(samples.house(), tmp_path_factory.mktemp("report"))[0]


@pytest.fixture
def page(written, tmp_path):
    """A copy of its own, to be changed."""
    return shutil.copytree(written.parent, tmp_path / "out") / written.name


def test_the_report_draws_in_a_browser_and_keeps_quiet(page, tmp_path):
    picture = tmp_path / "page.png"
    run = browse(page, tmp_path, "--window-size=1280,2000", f"--screenshot={picture}")
    assert picture.is_file(), run.stderr[-2000:]
    assert console(run) == []
    if images.oiio is None:
        pytest.skip("OpenImageIO's Python module is absent: the screenshot can't be looked at")
    pixels = images.read_image(picture).pixels[..., :3]
    walls = (np.abs(pixels - np.array([0x33, 0x36, 0x3B]) / 255).max(axis=2) < 0.02).mean()
    assert walls > 0.02, "the plan's walls are on the page"


def test_a_forbidden_request_would_be_heard(page, tmp_path):
    """The console check above can fail: a page that does ask for something is reported there."""
    text = page.read_text(encoding="utf-8").replace("<main>", '<main><img src="http://192.0.2.1/x.png" alt="">', 1)
    page.write_text(text, encoding="utf-8")
    assert any("Content Security Policy" in line for line in console(browse(page, tmp_path, f"--screenshot={tmp_path / 'p.png'}")))


def test_tables_sort_when_a_heading_is_clicked(page, tmp_path):
    click = ("<script>var h=document.querySelector('#rooms').parentNode.querySelectorAll('th')[3];h.click();"
             "document.title=h.closest('table').tBodies[0].rows[0].cells[1].textContent+'/'+h.getAttribute('aria-sort')</script></body>")
    page.write_text(page.read_text(encoding="utf-8").replace("</body>", click), encoding="utf-8")
    run = browse(page, tmp_path, "--dump-dom")
    assert "<title>Kitchen/ascending</title>" in run.stdout


def test_long_tables_are_searched_as_one_types(tmp_path, monkeypatch):
    monkeypatch.setattr(html, "LONG", 3)
    page = write_report(samples.house(), tmp_path / "out")[0]
    typed = ("<script>var s=document.querySelector('#rooms').parentNode,f=s.querySelector('.find');f.value='kitch';"
             "f.dispatchEvent(new Event('input'));document.title=Array.prototype.filter.call(s.querySelectorAll('tbody tr'),"
             "function(r){return !r.hidden}).map(function(r){return r.cells[1].textContent}).join()</script></body>")
    page.write_text(page.read_text(encoding="utf-8").replace("</body>", typed), encoding="utf-8")
    assert "<title>Kitchen</title>" in browse(page, tmp_path, "--dump-dom").stdout
