"""A real browser without a window: the fixture `page` for tests of what people open in one.

Import the fixture where it is used: `from headless_browser import page  # noqa: F401`.
"""

import os
import shutil

import pytest

ALL_TOOLS = "MRTS_ALL_TOOLS"
"""Environment variable under which a missing tool is a failure."""

WIDE = {"width": 1300, "height": 900}


@pytest.fixture(scope="session")
def browser():
    """Chromium; without it the test is skipped, or fails where every tool must be there."""
    program = shutil.which("chromium")
    if program is None:
        missing = "needs chromium (Debian package chromium)"
        (pytest.fail if os.environ.get(ALL_TOOLS) == "1" else pytest.skip)(missing)
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 (only where there is a browser)

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield running
        running.close()


@pytest.fixture
def page(browser):
    """A new page that collects what goes wrong in `page.problems`: errors, exceptions, requests that failed."""
    context = browser.new_context(viewport=WIDE)
    opened = context.new_page()
    opened.problems = []
    opened.on("console", lambda said: said.type == "error" and opened.problems.append(said.text))
    opened.on("pageerror", lambda error: opened.problems.append(str(error)))
    opened.on("requestfailed", lambda request: opened.problems.append(f"failed: {request.url}"))
    yield opened
    context.close()
