# SPDX-License-Identifier: MIT
"""`mrts view`."""

import os
import signal
import sys
import webbrowser
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import argument, option

from mrts.commands import options
from mrts.commands.options import Named, require, take
from mrts.commands.showing.films import OF_FILMS, check_films, film_options, played_sides, saved_clip, write_films
from mrts.commands.showing.shown import is_saved, played, shown_files, shown_urdfs
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.progress import working
from mrts.console.terminal import say, warn

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from mrts.viewer.choices import Given
    from mrts.viewer.film_controls import Others
    from mrts.viewer.server import GuardedServer
    from mrts.viewer.viewer import Viewer

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


@options.command(EXAMPLES)
@argument("cell", type=Named(), metavar="CELL",
          help="cell file, folder that `mrts generate` wrote, RESULT.npz of `mrts scale --save`, or, with --variant, a "
          "study file or the folder of its sweep")  # fmt: skip
@argument("motion", type=Named(), required=False, metavar="[MOTION]",
          help="motion file, CSV table, or ROS 2 bag with joint trajectories; without one the cell stands at its "
          "posture, and no compiler is needed")  # fmt: skip
@option("--with", "others", type=Named(), multiple=True, metavar="RESULT.npz",
        help="a saved result to show beside it; may be given again")  # fmt: skip
@option("--variant", type=int, metavar="N", help="of the study: its cell and its motion")
@options.closure
@options.share
@options.limits
@film_options
@option("--host", default=LOCAL[0], show_default=True, help="address to listen at; the default is this machine only")
@option("--port", type=int, default=8080, show_default=True, help="port; 0 takes any free one")
@option("--no-open", is_flag=True, help="do not open a browser")
def run(
    cell: Path,
    host: str,
    motion: Path | None = None,
    variant: int | None = None,
    others: tuple[Path, ...] = (),
    png: Path | None = None,
    video: Path | None = None,
    port: int = 0,
    *,
    no_open: bool = False,
    **given: Any,
) -> int:
    """A cell in the browser, its motion at any speed against all limits, until Ctrl-C; or as a picture or a film."""
    of_films = take(given, OF_FILMS)
    check_films(cell, png, video, of_films)
    needing = [name for name, value in (("png", png), ("video", video), ("others", others)) if value]
    with shown_files(cell, motion, variant, given, needing) as (cell_file, motion_file):
        if png is None and video is None:
            require("mrts view", "view", "viser")
            beside = [(path.stem, played(path)) for path in others]
            follow = partial(_follow, host=host, opens=not no_open)
            if is_saved(cell):
                return _serve_saved(cell, beside, host, port, follow)
            cell_path = None if variant is not None else cell_file
            return _serve(cell_file, motion_file, cell_path, given, beside, host, port, follow)
        if motion_file is None:
            clips, within = [saved_clip(cell)], True
        else:
            sides, rates = of_films.get("side_by_side", ["fastest"]), of_films.get("rates", True)
            clips, within = played_sides(cell_file, motion_file, sides, rates, given)
        return write_films([*clips, *map(saved_clip, others)], png, video, of_films.get("at"), within=within)


def _serve(
    cell: Path,
    motion: Path | None,
    cell_path: Path | None,
    given: dict[str, Any],
    others: "Others",
    host: str,
    port: int,
    follow: "Callable[..., None]",
) -> int:
    from mrts.viewer.viewer import Viewer
    from mrts.viewer.workbench import Workbench

    urdfs = shown_urdfs(cell)
    start = _start(cell, motion, cell_path if urdfs else None, given)
    name = start.cell.name
    with _server(host, port, name) as server:
        with working("looking at the cell" if start.stands else f"scaling {motion}") as progress:
            bench = Workbench(start, progress)
        first = bench.answer
        viewer = Viewer(server, bench, urdfs, warn, others)
        if start.stands and first.held is not None:
            follow(server, viewer, f"{name}: no motion was given, the cell stands at its posture")
            return FEASIBLE if first.held.reached.all() else INFEASIBLE
        outcome = first.message if first.state is None else first.state.result.summary()
        follow(server, viewer, f"{name}: {outcome}")
    return FEASIBLE if first.state is not None and first.state.result.status.admits_motion else INFEASIBLE


def _start(cell: Path, motion: Path | None, cell_path: Path | None, given: dict[str, Any]) -> "Given":
    from mrts.viewer.choices import Given

    if motion is None:
        from mrts.cell.loading import cell_to_compile
        from mrts.viewer.held_poses import still_motion

        alone = cell_to_compile(cell) or options.compiled_cell(cell)
        return Given(cell=alone, motion=still_motion(alone), cell_path=cell_path, stands=True)
    from mrts.motion.motion_file import described_motion, load_motion

    played_motion = load_motion(motion)
    return Given(
        cell=options.limited_cell(cell, **take(given, options.LIMITS)),
        motion=played_motion,
        description=described_motion(motion),
        cell_path=cell_path,
        motion_path=motion,
        **given,
    )


def _serve_saved(path: Path, others: "Others", host: str, port: int, follow: "Callable[..., None]") -> int:
    from mrts.viewer.player_state import PlayerState
    from mrts.viewer.viewer import Viewer

    result = played(path)
    with _server(host, port, result.cell.name) as server:
        viewer = Viewer(server, PlayerState.saved(result), {}, warn, others)
        follow(server, viewer, f"{result.cell.name}: {result.summary()}")
    return FEASIBLE


@contextmanager
def _server(host: str, port: int, name: str) -> "Iterator[GuardedServer]":
    from mrts.viewer.server import close_server, open_server

    server = open_server(host, port, f"mrts: {name}")
    try:
        yield server
    finally:
        close_server(server)


def _follow(server: "GuardedServer", viewer: "Viewer", outcome: str, *, host: str, opens: bool) -> None:
    if host not in LOCAL:
        warn(f"everyone who reaches {host} and knows the address can watch and steer this viewer")
    say(outcome)
    say(f"viewer at {server.url} (Ctrl-C ends it)")
    sys.stdout.flush()
    if opens and _has_display():
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
