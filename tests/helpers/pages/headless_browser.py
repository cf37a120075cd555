"""A real browser without a window; import the fixtures `browser` and `page` where a page is tested."""

import os
import shutil
from contextlib import contextmanager

import pytest
from playwright.sync_api import sync_playwright

WIDE = {"width": 1300, "height": 900}
NARROW = {"width": 420, "height": 800}

COARSE = 0.5
"""Pixels a point of the page: it is drawn without a graphics card, and tests compare whole pictures at most."""


@contextmanager
def running_chromium(*arguments):
    """Chromium; without it a test fails where all tools are promised, and is skipped with advice elsewhere."""
    program = shutil.which("chromium")
    if program is None:
        assert "MRTS_ALL_TOOLS" not in os.environ, "apt-get install chromium"
        pytest.skip("needs chromium: apt-get install chromium")
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *arguments])
        yield running
        running.close()


@pytest.fixture(scope="module")
def browser():
    with running_chromium() as running:
        yield running


@pytest.fixture
def page(browser):
    """A new page without a network; `requests` holds what it asked for, `problems` what went wrong."""
    context = browser.new_context(viewport=WIDE, offline=True, device_scale_factor=COARSE)
    opened = context.new_page()
    opened.requests, opened.problems = [], []
    opened.on("request", lambda request: opened.requests.append(request.url))
    opened.on("console", lambda said: said.type == "error" and opened.problems.append(said.text))
    opened.on("pageerror", lambda error: opened.problems.append(str(error)))
    yield opened
    context.close()
