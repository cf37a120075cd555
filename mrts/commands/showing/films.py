# SPDX-License-Identifier: MIT
"""The pictures and films of `mrts view`, written without a display."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import option

from mrts.base.errors import InputError
from mrts.commands import options
from mrts.commands.options import Written
from mrts.commands.showing.shown import is_saved, played, shown_urdfs
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs
from mrts.console.progress import working
from mrts.console.terminal import warn

if TYPE_CHECKING:
    from mrts.film.renderer import Clip
    from mrts.program.rate_limits import Rates

SIDES = ("given", "fastest", "optimal", "smooth")
"""How a motion may be played: as given, by the fastest constant factor, at the fastest timing, at the smooth one."""

MOST_SIDES = 4

OF_FILMS = ("at", "side_by_side", "rates")
"""Arguments of pictures and films."""

NEEDS: dict[str, Any] = {"needs": ("matplotlib", "mujoco", "PIL"), "extra": "film"}


def _sides(text: str) -> list[str]:
    sides = [word.strip() for word in text.split(",")]
    for side in sides:
        if side not in SIDES:
            raise InputError("side_by_side", f"there is no such side; there are {', '.join(SIDES)}.", value=side)
    if len(set(sides)) < len(sides):
        raise InputError("side_by_side", "names a side twice.", value=text)
    return sides


def film_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options that write files in place of the page."""
    for decorator in (
        options.rates,
        option("--side-by-side", type=_sides, metavar="SIDE,…",
               help="in pictures and films, the motion as it is played in several ways: "
               f"{', '.join(SIDES)} (default: fastest); --rates are of the smooth side"),
        option("--video", type=Written(".gif", ".mp4", **NEEDS), metavar="FILE",
               help="write a film, FILE.gif or FILE.mp4, and end; needs no display (extra 'film')"),
        option("--at", type=float, metavar="SECONDS", help="the moment of the picture (default: the middle)"),
        option("--png", type=Written(".png", **NEEDS), metavar="FILE",
               help="write a picture and end; needs no display (extra 'film')"),
    ):  # fmt: skip
        function = decorator(function)
    return function


def check_films(cell: Path, png: Path | None, video: Path | None, of_films: dict[str, Any]) -> None:
    """Check that the arguments of pictures and films go together.

    Raises:
        InputError: If they do not.
    """
    sides = of_films.get("side_by_side", ["fastest"])
    if png is None and video is None:
        for name in of_films:
            raise InputError(name, "goes with --png FILE or --video FILE.")
    elif "at" in of_films and png is None:
        raise InputError("at", "is the moment of --png FILE.")
    elif "side_by_side" in of_films and is_saved(cell):
        raise InputError("side_by_side", "goes with CELL MOTION; a saved result is played as it is.")
    elif "rates" in of_films and "smooth" not in sides:
        raise InputError("rates", "is of the smooth side: give --side-by-side smooth too.")
    if png is not None or video is not None:
        from mrts.film.film import check_film
        from mrts.film.renderer import require_renderer

        if video is not None:
            check_film(video)
        require_renderer()


def write_films(clips: "list[Clip]", png: Path | None, video: Path | None, at: float | None, *, within: bool) -> int:
    """Write a picture and a film.

    Args:
        clips: What is played.
        png: The picture; None for none.
        video: The film; None for none.
        at: Moment of the picture [s]; None for the middle.
        within: Whether all of it keeps its limits.

    Returns:
        Exit code: that of the outcome.
    """
    from mrts.film.film import write_film, write_picture

    if len(clips) > MOST_SIDES:
        raise InputError("others", f"there is room for {MOST_SIDES} motions side by side.")
    longest = max(clip.trajectory.duration for clip in clips)
    moment = longest / 2 if at is None else at
    if not 0 <= moment <= longest:
        raise InputError("at", f"must be a time of the motion, from 0 to {longest:.4g} s.", value=moment)
    outputs = Outputs()
    with working(f"drawing {png}"):
        outputs.write(png, lambda file: write_picture(clips, file, moment, warn=warn))
    with working(f"drawing {video}") as progress:
        outputs.write(video, lambda file: write_film(clips, file, warn=warn, progress=progress))
    return outputs.answer((), FEASIBLE if within else INFEASIBLE)


def saved_clip(path: Path) -> "Clip":
    """A saved result to play."""
    from mrts.film.renderer import Clip

    result = played(path)
    assert result.trajectory is not None  # noqa: S101 (what is played has one)
    return Clip(path.stem, result.trajectory, result.range)


def played_sides(
    cell_path: Path, motion_path: Path, sides: list[str], rates: "Rates", given: dict[str, Any]
) -> "tuple[list[Clip], bool]":
    """The motion as it is played in several ways, and whether all of it keeps its limits."""
    from mrts.film.renderer import Clip
    from mrts.motion.motion_file import load_motion
    from mrts.timing.retime import retime
    from mrts.viewer.player_state import PlayerState

    motion, limits = load_motion(motion_path), options.take(given, options.LIMITS)
    cell, urdfs = options.limited_cell(cell_path, **limits), shown_urdfs(cell_path)
    clips, within = [], True
    with working(f"scaling {motion_path}") as progress:
        state = PlayerState(cell, motion, **given, progress=progress)
    for side in sides:
        if side == "given":
            state.choose_speed(1.0)
            within &= state.admissible
            title, result = "as given" if within else "as given: beyond its limits", state.result
            trajectory = state.trajectory
        elif side == "fastest":
            state.choose_speed(state.speeds.start)
            if not state.admissible:
                raise InputError("side_by_side", f"no speed is admissible: {state.result.sentence()}", value=side)
            title, trajectory, result = f"constant factor {state.trajectory.c:.3g}", state.trajectory, state.result
        else:
            with working(f"timing {motion_path}") as progress:
                found = retime(cell, motion, **given, rates=rates if side == "smooth" else False, progress=progress)
            if found.retimed is None or found.retimed.trajectory is None:
                raise InputError("side_by_side", f"there is no such timing: {found.sentence()}", value=side)
            title, result = f"{'fastest' if side == 'optimal' else side} timing", found.retimed
            trajectory = found.retimed.trajectory
        clips.append(Clip(title, trajectory, result.range, urdfs))
    return clips, within
