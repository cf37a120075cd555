# SPDX-License-Identifier: MIT
"""`mrts view`."""

import argparse
import os
import signal
import sys
import webbrowser
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from mrts.commands.options.common import (
    add_closure,
    add_reserve,
    cell_option,
    closure_option,
    limited_cell_option,
    require,
    sharing_option,
)
from mrts.commands.showing.films import add_films, write_films, writes_films
from mrts.commands.showing.shown import add_shown, is_saved, played, shown_files, shown_urdfs
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.progress import working
from mrts.console.terminal import say, warn

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mrts.viewer.guard import GuardedServer
    from mrts.viewer.plots.other_result import Others
    from mrts.viewer.viewer import Viewer
    from mrts.viewer.workbench.choices import Given

EXAMPLES = """\
examples:
  mrts view cell.yaml motion.yaml
  mrts view cell.yaml --no-open
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
    others = [(path.stem, played(path)) for path in options.others]
    if is_saved(options):
        return _serve_saved(options, others)
    from mrts.viewer.viewer import Viewer
    from mrts.viewer.workbench.workbench import Workbench

    urdfs = shown_urdfs(options)
    cell_path = options.cell if urdfs and options.variant is None else None
    given = _given_cell(options, cell_path) if options.motion is None else _given(options, cell_path)
    name = given.cell.name
    with _server(options, name) as server:
        with working("looking at the cell" if given.stands else f"scaling {options.motion}") as progress:
            bench = Workbench(given, progress)
        first = bench.answer
        viewer = Viewer(server, bench, urdfs, warn, others)
        if given.stands and first.held is not None:
            _follow(options, server, viewer, f"{name}: no motion was given, the cell stands at its posture")
            return FEASIBLE if first.held.reached.all() else INFEASIBLE
        outcome = first.message if first.state is None else first.state.result.summary()
        _follow(options, server, viewer, f"{name}: {outcome}")
    return FEASIBLE if first.state is not None and first.state.result.status.admits_motion else INFEASIBLE


def _given(options: argparse.Namespace, cell_path: "Path | None") -> "Given":
    """The cell and the motion that are named."""
    from mrts.motion.motion_file import described_motion, load_motion
    from mrts.viewer.workbench.choices import Given

    motion = load_motion(options.motion)
    sharing, closure = sharing_option(options.share), closure_option(options.closure)
    return Given(
        cell=limited_cell_option(options),
        motion=motion,
        description=described_motion(options.motion),
        cell_path=cell_path,
        motion_path=options.motion,
        sharing=sharing,
        closure=closure,
    )


def _given_cell(options: argparse.Namespace, cell_path: "Path | None") -> "Given":
    """The cell alone, whose arms hold the object still."""
    from mrts.cell.loading import cell_to_compile
    from mrts.viewer.workbench.choices import Given
    from mrts.viewer.workbench.held_poses import still_motion

    cell = cell_to_compile(options.cell) or cell_option(options.cell)
    return Given(cell=cell, motion=still_motion(cell), cell_path=cell_path, stands=True)


def _serve_saved(options: argparse.Namespace, others: "Others") -> int:
    """Show a saved result, which takes neither its cell's files nor a compiler."""
    from mrts.viewer.player_state import PlayerState
    from mrts.viewer.viewer import Viewer

    result = played(options.cell)
    with _server(options, result.cell.name) as server:
        viewer = Viewer(server, PlayerState.saved(result), {}, warn, others)
        _follow(options, server, viewer, f"{result.cell.name}: {result.summary()}")
    return FEASIBLE


@contextmanager
def _server(options: argparse.Namespace, name: str) -> "Iterator[GuardedServer]":
    """A server where the options want it, as long as it is needed."""
    from mrts.viewer.server import close_server, open_server

    server = open_server(options.host, options.port, f"mrts: {name}")
    try:
        yield server
    finally:
        close_server(server)


def _follow(options: argparse.Namespace, server: "GuardedServer", viewer: "Viewer", outcome: str) -> None:
    """Say where the viewer is, and follow its controls until Ctrl-C."""
    if options.host not in LOCAL:
        warn(f"everyone who reaches {options.host} and knows the address can watch and steer this viewer")
    say(outcome)
    say(f"viewer at {server.url} (Ctrl-C ends it)")
    sys.stdout.flush()
    if not options.no_open and _has_display():
        with suppress(webbrowser.Error):
            webbrowser.open(server.url)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # here Ctrl-C is how one leaves
    try:
        viewer.run()
    finally:
        viewer.close()
        signal.signal(signal.SIGINT, before)


def _has_display() -> bool:
    """Whether a browser would have a window: without one, a text browser would take the terminal."""
    return sys.platform in {"darwin", "win32"} or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
