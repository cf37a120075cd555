"""A viewer in a process of its own, seen through a headless Chromium."""

import re
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest
from headless_browser import running_chromium

SECONDS = 60
SIZE = {"width": 1200, "height": 700}

COARSE = 0.25
"""Pixels a point of the page: the scene is drawn without a graphics card, and no test looks at its pixels."""


@contextmanager
def running_viewer(*arguments):
    """`mrts view` on a free port: its process, and its URL."""
    command = [sys.executable, "-m", "mrts", "view", *map(str, arguments), "--port", "0", "--no-open"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            said = ""
            while not (found := re.search(r"http://\S+", said)):
                line = process.stdout.readline()
                assert line, f"{said}{process.stderr.read()}"
                said += line
            process.said = said
            yield process, found.group()
        finally:
            if process.poll() is None:
                process.kill()


def interrupt(process):
    """Ctrl-C; all that the viewer says, and its exit code."""
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=SECONDS)
    return process.said + out, err, process.returncode


@pytest.fixture(scope="module")
def chromium():
    with running_chromium("--use-angle=swiftshader", "--enable-unsafe-swiftshader") as running:
        yield running


@contextmanager
def open_page(browser, url):
    """The viewer's page once its panel is there; what went wrong in it is in `page.problems`."""
    page = browser.new_page(viewport=SIZE, device_scale_factor=COARSE)
    page.set_default_timeout(1000 * SECONDS)
    page.problems = []
    page.on("console", lambda message: page.problems.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.goto(url)
    page.wait_for_selector("[data-bar]", timeout=1000 * SECONDS)
    try:
        yield page
    finally:
        page.close()
