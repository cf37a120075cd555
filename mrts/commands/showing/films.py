# SPDX-License-Identifier: MIT
"""The pictures and films of `mrts view`, written without a display."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.errors import InputError
from mrts.commands.options.common import closure_option, limited_cell_option, require, sharing_option
from mrts.commands.options.profile import rate_share, told_of
from mrts.commands.showing.shown import is_saved, played, shown_urdfs
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import say, warn

if TYPE_CHECKING:
    from mrts.film.renderer import Clip

SIDES = ("given", "fastest", "optimal", "smooth")
"""How a motion may be played: as given, by the fastest constant factor, at the fastest timing, at the smooth one."""

MOST_SIDES = 4

OF_FILMS = ("side_by_side", "at", "rates")
"""Options that mean nothing without a picture or a film."""


def add_films(view: argparse.ArgumentParser) -> None:
    """Add the options that write files in place of the page."""
    view.add_argument("--png", type=Path, metavar="FILE",
                      help="write a picture and end; needs no display (extra 'film')")  # fmt: skip
    view.add_argument("--at", type=float, metavar="SECONDS", help="the moment of the picture (default: the middle)")
    view.add_argument("--video", type=Path, metavar="FILE",
                      help="write a film, FILE.gif or FILE.mp4, and end; likewise")  # fmt: skip
    view.add_argument("--side-by-side", metavar="SIDE,…",
                      help="in pictures and films, the motion as it is played in several ways: "
                      f"{', '.join(SIDES)} (default: fastest)")  # fmt: skip
    view.add_argument("--rates", type=rate_share, nargs="?", const=True, metavar="SHARE",
                      help="of the smooth side, as in mrts scale")  # fmt: skip


def writes_films(options: argparse.Namespace) -> bool:
    """Whether files are asked for in place of the page; what is wrong with their options is told now.

    Raises:
        InputError: If an option is wrong, or a file cannot be written.
    """
    wanted = options.png is not None or options.video is not None
    given = {f"--{name.replace('_', '-')}": getattr(options, name) is not None for name in OF_FILMS}
    if not wanted:
        for name in (name for name, is_given in given.items() if is_given):
            raise InputError(name, "goes with --png FILE or --video FILE.")
        return False
    for package in ("matplotlib", "mujoco", "PIL"):
        require(package, "--png" if options.video is None else "--video", "film", wanted=True)
    if given["--at"] and options.png is None:
        raise InputError("--at", "is the moment of --png FILE.")
    if options.png is not None and options.png.suffix.lower() != ".png":
        raise InputError("--png", "writes a file that ends in .png.", value=str(options.png))
    from mrts.film.film import check_film
    from mrts.film.renderer import require_renderer

    if options.video is not None:
        check_film(options.video)
    check_outputs({"--png": options.png, "--video": options.video})
    if "smooth" not in _sides(options) and given["--rates"]:
        raise InputError("--rates", "is of the smooth side: give --side-by-side smooth too.")
    require_renderer()
    return True


def write_films(options: argparse.Namespace) -> int:
    """Write what was asked for; the exit code is that of the outcome."""
    from mrts.film.film import write_film, write_picture

    clips, within = _clips(options)
    outputs = Outputs()
    if options.png is not None:
        longest = max(clip.trajectory.duration for clip in clips)
        at = longest / 2 if options.at is None else options.at
        if not 0 <= at <= longest:
            raise InputError("--at", f"must be a time of the motion, from 0 to {longest:.4g} s.", value=at)
        with outputs.attempt(options.png), working(f"drawing {options.png}"):
            write_picture(clips, options.png, at, warn=warn)
    if options.video is not None:
        with outputs.attempt(options.video), working(f"drawing {options.video}") as progress:
            write_film(clips, options.video, warn=warn, progress=progress)
    for line in outputs.lines():
        say(line.lstrip("\n"))
    return outputs.code(FEASIBLE if within else INFEASIBLE)


def _sides(options: argparse.Namespace) -> list[str]:
    """The sides that are asked for."""
    if options.side_by_side is None:
        return ["fastest"]
    if is_saved(options):
        rule = "goes with CELL MOTION; a saved result is played as it is."
        raise InputError(options.cell, rule, key="--side-by-side")
    sides = [word.strip() for word in options.side_by_side.split(",")]
    for side in sides:
        if side not in SIDES:
            raise InputError("--side-by-side", f"there is no such side; there are {', '.join(SIDES)}.", value=side)
    if len(set(sides)) < len(sides):
        raise InputError("--side-by-side", "names a side twice.", value=options.side_by_side)
    return sides


def _clips(options: argparse.Namespace) -> "tuple[list[Clip], bool]":
    """What is played, and whether all of it keeps its limits."""
    from mrts.film.renderer import Clip

    def saved(path: Path) -> Clip:
        result = played(path)
        assert result.trajectory is not None  # noqa: S101 (what is played has one)
        return Clip(path.stem, result.trajectory, result.range)

    others = [saved(other) for other in options.others]
    if is_saved(options):
        clips, within = [saved(options.cell)], True
    else:
        clips, within = _played_sides(options)
    if len(clips) + len(others) > MOST_SIDES:
        raise InputError("--with", f"there is room for {MOST_SIDES} motions side by side.")
    return [*clips, *others], within


def _played_sides(options: argparse.Namespace) -> "tuple[list[Clip], bool]":
    from mrts.film.renderer import Clip
    from mrts.motion.motion_file import load_motion
    from mrts.program.rate_limits import rate_limits
    from mrts.timing.retime import retime
    from mrts.viewer.player_state import PlayerState

    motion = load_motion(options.motion)
    sharing, closure = sharing_option(options.share), closure_option(options.closure)
    cell, urdfs, sides = limited_cell_option(options), shown_urdfs(options), _sides(options)
    clips, within = [], True
    with working(f"scaling {options.motion}") as progress:
        state = PlayerState(cell, motion, sharing=sharing, closure=closure, progress=progress)
    for side in sides:
        if side == "given":
            state.choose_speed(1.0)
            within &= state.admissible
            title = "as given" if state.admissible else "as given: beyond its limits"
            clips.append(Clip(title, state.trajectory, state.result.range, urdfs))
        elif side == "fastest":
            state.choose_speed(state.speeds.start)
            if not state.admissible:
                raise InputError("--side-by-side", f"no speed is admissible: {state.result.sentence()}", value=side)
            clips.append(Clip(f"constant factor {state.trajectory.c:.3g}", state.trajectory, state.result.range, urdfs))
        else:
            rates = (options.rates or True) if side == "smooth" else False
            if rates:
                with told_of("--rates"):
                    rate_limits(cell, rates)
            with working(f"timing {options.motion}") as progress:
                found = retime(cell, motion, sharing=sharing, closure=closure, rates=rates, progress=progress)
            timed, title = found.retimed, f"{'fastest' if side == 'optimal' else side} timing"
            if timed is None or timed.trajectory is None:
                raise InputError("--side-by-side", f"there is no such timing: {found.sentence()}", value=side)
            clips.append(Clip(title, timed.trajectory, timed.range, urdfs))
    return clips, within
