# SPDX-License-Identifier: MIT
"""`mrts view`: a cell and a motion, or a saved result, in the browser or as pictures."""

import os
import signal
import sys
import webbrowser
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import IntRange, argument, option

from mrts.base.errors import InputError, require_extra
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, Outputs, say, warn, working
from mrts.commands.options import Named, Written, take

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.motion.joint_table import JointTable
    from mrts.motion.object_motion import ObjectMotion
    from mrts.program.rate_limits import Rates
    from mrts.scene.renderer import Clip
    from mrts.viewer.player_state import PlayerState
    from mrts.viewer.server import GuardedServer
    from mrts.viewer.viewer import Viewer
    from mrts.viewer.workbench import Given

LOCAL = ("127.0.0.1", "localhost", "::1")
"""Where nobody else can reach the viewer."""

SIDES = ("given", "fastest", "optimal", "smooth")
"""How a motion may be played: as given, by the fastest constant factor, at the fastest timing, at the smooth one."""

OF_FILMS = ("at", "side_by_side", "rates")
"""Arguments of pictures and films."""

NEEDS: dict[str, Any] = {"needs": ("matplotlib", "mujoco", "PIL"), "extra": "film"}


def _sides(text: str) -> list[str]:
    """Names of `SIDES` with commas between them."""
    found = [word.strip() for word in text.split(",")]
    for side in found:
        if side not in SIDES:
            raise InputError("side_by_side", f"there is no such side; there are {', '.join(SIDES)}.", value=side)
    return found


@options.command
@argument("cell", type=Named(), metavar="CELL",
          help="cell file, folder that `mrts generate` wrote, or RESULT.npz of `mrts scale --save`")  # fmt: skip
@argument("motion", type=Named(), required=False, metavar="[MOTION]",
          help="motion file, CSV table, or ROS 2 bag with joint trajectories; without one the cell stands at its "
          "posture, and no compiler is needed")  # fmt: skip
@options.closure
@options.share
@options.limits
@option("--png", type=Written(".png", **NEEDS), metavar="FILE",
        help="write a picture and end; needs no display (extra 'film')")  # fmt: skip
@option("--at", type=float, metavar="SECONDS", help="the moment of the picture (default: the middle)")
@option("--video", type=Written(".gif", ".mp4", **NEEDS), metavar="FILE",
        help="write a film, FILE.gif or FILE.mp4, and end; needs no display (extra 'film')")  # fmt: skip
@option("--side-by-side", type=_sides, metavar="SIDE,…",
        help=f"in pictures and films, the motion as it is played in several ways: {', '.join(SIDES)} (default: "
        "fastest); --rates are of the smooth side")  # fmt: skip
@options.rates
@option("--host", default=LOCAL[0], show_default=True, help="address to listen at; the default is this machine only")
@option("--port", type=IntRange(0, 65535), default=8080, show_default=True, help="port; 0 takes any free one")
@option("--no-open", is_flag=True, help="do not open a browser")
def run(
    cell: Path,
    host: str,
    motion: Path | None = None,
    png: Path | None = None,
    video: Path | None = None,
    port: int = 0,
    *,
    no_open: bool = False,
    **given: Any,
) -> int:
    """A cell in the browser, its motion at any speed against all limits, until Ctrl-C; or as a picture or a film.

    Examples:
        mrts view cell.yaml motion.yaml
        mrts view cell.yaml --no-open
        mrts view cell.yaml motion.yaml --port 0 --no-open
        mrts view cell.yaml motion.yaml --png moment.png --at 0.2
        mrts view cell.yaml motion.yaml --video lift.gif --side-by-side given,fastest,smooth --rates 11.5
    """
    of_films = take(given, OF_FILMS)
    drawn = [name for name, file in (("png", png), ("video", video)) if file is not None]
    saved = cell.suffix == ".npz"
    rules = (
        (not drawn, of_films, "goes with --png FILE or --video FILE."),
        (png is None, ["at"], "is the moment of --png FILE."),
        (saved, ["motion", "side_by_side", *given], "does not go with a saved result, which is played as found."),
        (not saved and motion is None, [*given, *drawn], "needs a motion: mrts view CELL MOTION."),
        ("smooth" not in of_films.get("side_by_side", ()), ["rates"], "is of the smooth side: give it too."),
    )
    asked = {*of_films, *given, *drawn, *(["motion"] if motion else [])}
    for broken, names, rule in rules:
        if broken and (wrong := [name for name in names if name in asked]):
            raise InputError(wrong[0], rule)
    if not drawn:
        require_extra("mrts view", "view", "viser")
        source = _saved(cell) if saved else _start(cell, motion, given)
        return _serve(source, host, port, opens=not no_open)
    from mrts.motion.motion_file import load_motion
    from mrts.scene.renderer import Clip, require_renderer

    if video is not None and video.suffix.lower() == ".mp4":
        require_extra("--video", "film", "imageio_ffmpeg")
    require_renderer()
    clips, within = [], True
    if saved:
        state, title = _saved(cell), "smooth timing"
        if state.timing is None:
            title = f"c² = {state.trajectory.c2:.4g}"
        elif state.timing.smooth is None:
            title = "fastest timing"
        clips.append(Clip(title, state.trajectory, state.card.deciding, state.result.options.rates))
    elif motion is not None:
        played, limited = load_motion(motion), options.compiled_cell(cell, **take(given, options.LIMITS))
        for side in of_films.get("side_by_side", ["fastest"]):
            clip, keeps = _side_clip(side, limited, played, of_films.get("rates", True), given)
            clips.append(clip)
            within &= keeps
    return _write_films(clips, png, video, of_films.get("at"), within=within)


def _saved(path: Path) -> "PlayerState":
    from mrts.output.saved_result import load_result
    from mrts.scaling.scale import ScalingResult
    from mrts.viewer.player_state import PlayerState

    found = load_result(path)
    result = found if isinstance(found, ScalingResult) else found.retimed
    if result is None or result.trajectory is None:
        possible = "what some load admits chooses no c² and no torques"
        why = possible if found.status.admits_motion else found.status.value
        raise InputError(path, f"has no motion to play: {why}.")
    return PlayerState.saved(found)


def _write_films(clips: "list[Clip]", png: Path | None, video: Path | None, at: float | None, *, within: bool) -> int:
    """Write a picture, at a moment [s] or in the middle, and a film; the exit code is whether all keeps its limits."""
    from mrts.output.film import write_film, write_picture

    longest = max(clip.trajectory.duration for clip in clips)
    moment = longest / 2 if at is None else at
    if not 0 <= moment <= longest:
        raise InputError("at", f"must be a time of the motion, from 0 to {longest:.4g} s.", value=moment)
    outputs = Outputs()
    if png is not None:
        with working(f"drawing {png}"):
            outputs.write(png, lambda file: write_picture(clips, file, moment, warn=warn))
    if video is not None:
        with working(f"drawing {video}") as progress:
            outputs.write(video, lambda file: write_film(clips, file, warn=warn, progress=progress))
    return outputs.answer((), FEASIBLE if within else INFEASIBLE)


def _side_clip(
    side: str, cell: "Cell", motion: "ObjectMotion | JointTable", rates: "Rates", given: dict[str, Any]
) -> "tuple[Clip, bool]":
    """The motion as it is played in one way, and whether it keeps its limits."""
    from mrts.scene.renderer import Clip
    from mrts.viewer.player_state import play

    profile: Any = side if side in {"optimal", "smooth"} else "constant"
    with working("scaling" if profile == "constant" else "timing") as progress:
        state = play(cell, motion, **given, profile=profile, rates=rates, progress=progress)
    if side == "given":
        state = state.at_speed(1.0)
        title = "as given" if state.admissible else "as given: beyond its limits"
    elif not (state.found.status.admits_motion and state.admissible):
        raise InputError("side_by_side", f"there is no such motion: {state.found.sentence()}", value=side)
    else:
        titles = {"fastest": f"constant factor {state.trajectory.c:.3g}", "optimal": "fastest timing"}
        title = titles.get(side, "smooth timing")
    return Clip(title, state.trajectory, state.card.deciding, state.result.options.rates), state.admissible


def _start(cell: Path, motion: Path | None, given: dict[str, Any]) -> "Given":
    from mrts.viewer.workbench import Given

    if motion is None:
        from mrts.cell.cell import cell_to_compile

        return Given(cell_to_compile(cell) or options.compiled_cell(cell), None)
    from mrts.motion.motion_file import described_motion, load_motion

    played, limited = load_motion(motion), options.compiled_cell(cell, **take(given, options.LIMITS))
    return Given(limited, played, described_motion(motion), given)


def _serve(source: "Given | PlayerState", host: str, port: int, *, opens: bool) -> int:
    from mrts.viewer.player_state import HeldPoses, PlayerState
    from mrts.viewer.server import close_server, open_server
    from mrts.viewer.viewer import Viewer
    from mrts.viewer.workbench import Workbench

    name = source.result.cell.name if isinstance(source, PlayerState) else source.cell.name
    server = open_server(host, port, f"mrts: {name}")
    try:
        bench: PlayerState | Workbench
        if isinstance(source, PlayerState):
            bench = source
        else:
            with working("looking at the cell" if source.motion is None else f"scaling {name}") as progress:
                bench = Workbench(source, progress)
        viewer = Viewer(server, bench, warn)
        first = viewer.shown
        if isinstance(first, HeldPoses):
            outcome = first.message or "no motion was given, the cell stands at its posture"
            feasible = not first.message and bool(first.reached.all())
        else:
            outcome, feasible = first.result.summary(), first.result.status.admits_motion
        _follow(server, viewer, f"{name}: {outcome}", host, opens=opens)
    finally:
        close_server(server)
    return FEASIBLE if feasible else INFEASIBLE


def _follow(server: "GuardedServer", viewer: "Viewer", outcome: str, host: str, *, opens: bool) -> None:
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
