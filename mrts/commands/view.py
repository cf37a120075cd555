# SPDX-License-Identifier: MIT
"""`mrts view`."""

import argparse
import os
import signal
import sys
import webbrowser
from contextlib import suppress

from mrts.base.regular_file import is_folder
from mrts.commands.films import add_films, write_films, writes_films
from mrts.commands.options.common import (
    add_closure,
    add_reserve,
    closure_option,
    limited_cell_option,
    require,
    sharing_option,
)
from mrts.commands.shown import add_shown, shown_files
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.progress import working
from mrts.console.terminal import say, warn

EXAMPLES = """\
examples:
  mrts view cell.yaml motion.yaml
  mrts view cell.yaml motion.yaml --port 0 --no-open
  mrts view cell.yaml motion.yaml --png moment.png --at 0.2
  mrts view cell.yaml motion.yaml --video lift.gif --side-by-side given,fastest,smooth --rates 11.5
  mrts view study.yaml --variant 3 --png variant.png"""

LOCAL = ("127.0.0.1", "localhost", "::1")
"""Where nobody else can reach the viewer."""


def add(view: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    add_shown(view)
    add_closure(view)
    add_reserve(view)
    view.add_argument("--share", metavar="equal|A,B,…", help="fixed distribution of the load")
    view.add_argument("--no-wrench-limits", action="store_true", help="ignore the limits on the contact wrenches")
    view.add_argument("--no-velocity-limits", action="store_true", help="report velocity limits only")
    add_films(view)
    view.add_argument("--host", default=LOCAL[0], help="address to listen at (default: %(default)s, this machine only)")
    view.add_argument("--port", type=int, default=8080, help="port; 0 takes any free one (default: %(default)s)")
    view.add_argument("--no-open", action="store_true", help="do not open a browser")
    view.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Show the viewer until Ctrl-C, or write what it shows; the exit code is that of the outcome."""
    films = writes_films(options)
    with shown_files(options):
        return write_films(options) if films else _serve(options)


def _serve(options: argparse.Namespace) -> int:
    require("viser", "mrts view", "view", wanted=True)
    from mrts.base.manifest import MANIFEST_NAME
    from mrts.cell.generation import urdf_files
    from mrts.motion.motion_file import described_motion, load_motion
    from mrts.viewer.server import close_server, open_server
    from mrts.viewer.viewer import Viewer
    from mrts.viewer.workbench.choices import Given
    from mrts.viewer.workbench.workbench import Workbench

    motion = load_motion(options.motion)
    sharing, closure = sharing_option(options.share), closure_option(options.closure)
    cell = limited_cell_option(options)
    is_generated = is_folder(options.cell) or options.cell.name == MANIFEST_NAME
    urdfs = {} if is_generated else urdf_files(options.cell)
    given = Given(
        cell=cell,
        motion=motion,
        description=described_motion(options.motion),
        cell_path=None if is_generated else options.cell,
        motion_path=options.motion,
        sharing=sharing,
        closure=closure,
    )
    server = open_server(options.host, options.port, f"mrts: {cell.name}")
    try:
        with working(f"scaling {options.motion}") as progress:
            bench = Workbench(given, progress)
        first = bench.answer
        viewer = Viewer(server, bench, urdfs, warn)
        if options.host not in LOCAL:
            warn(f"everyone who reaches {options.host} and knows the address can watch and steer this viewer")
        say(f"{cell.name}: {first.message if first.state is None else first.state.result.summary()}")
        say(f"viewer at {server.url} (Ctrl-C ends it)")
        sys.stdout.flush()
        if not options.no_open and _has_display():
            with suppress(webbrowser.Error):
                webbrowser.open(server.url)
        before = signal.signal(signal.SIGINT, signal.default_int_handler)  # here Ctrl-C is how one leaves
        viewer.run()
        signal.signal(signal.SIGINT, before)
    finally:
        close_server(server)
    return FEASIBLE if first.state is not None and first.state.result.status.admits_motion else INFEASIBLE


def _has_display() -> bool:
    """Whether a browser would have a window: without one, a text browser would take the terminal."""
    return sys.platform in {"darwin", "win32"} or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
