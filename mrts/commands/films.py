# SPDX-License-Identifier: MIT
"""The pictures and films of `mrts view`, written without a display."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrts.base.errors import InputError
from mrts.commands.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.commands.console.output_files import Outputs
from mrts.commands.console.progress import working
from mrts.commands.console.terminal import warn

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.motion.joint_table import JointTable
    from mrts.motion.object_motion import ObjectMotion
    from mrts.program.rate_limits import Rates
    from mrts.scaling.result import ScalingResult
    from mrts.scene.arm_meshes import Urdfs
    from mrts.scene.renderer import Clip

SIDES = ("given", "fastest", "optimal", "smooth")
"""How a motion may be played: as given, by the fastest constant factor, at the fastest timing, at the smooth one."""

MOST_SIDES = 4


def sides(text: str) -> list[str]:
    """Names of `SIDES` with commas between them."""
    found = [word.strip() for word in text.split(",")]
    for side in found:
        if side not in SIDES:
            raise InputError("side_by_side", f"there is no such side; there are {', '.join(SIDES)}.", value=side)
    if len(set(found)) < len(found):
        raise InputError("side_by_side", "names a side twice.", value=text)
    return found


def write_films(clips: "list[Clip]", png: Path | None, video: Path | None, at: float | None, *, within: bool) -> int:
    """Write a picture, at a moment [s] or in the middle, and a film; the exit code is whether all keeps its limits."""
    from mrts.scene.film import write_film, write_picture

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


def saved_clip(name: str, result: "ScalingResult") -> "Clip":
    """A saved result to play."""
    from mrts.scene.renderer import Clip

    assert result.trajectory is not None  # noqa: S101 (what is played has one)
    return Clip(name, result.trajectory, result.range)


def side_clip(
    side: str, cell: "Cell", motion: "ObjectMotion | JointTable", urdfs: "Urdfs", rates: "Rates", given: dict[str, Any]
) -> "tuple[Clip, bool]":
    """The motion as it is played in one way, and whether it keeps its limits."""
    from mrts.scene.renderer import Clip
    from mrts.viewer.player_state import PlayerState

    profile: Any = side if side in {"optimal", "smooth"} else "constant"
    with working("scaling" if profile == "constant" else "timing") as progress:
        state = PlayerState(cell, motion, **given, profile=profile, rates=rates, progress=progress)
    if side == "given":
        state.choose_speed(1.0)
        title = "as given" if state.admissible else "as given: beyond its limits"
    elif state.refusal:
        raise InputError("side_by_side", f"there is no such timing: {state.refusal}", value=side)
    elif not state.admissible:
        raise InputError("side_by_side", f"no speed is admissible: {state.result.sentence()}", value=side)
    else:
        titles = {"fastest": f"constant factor {state.trajectory.c:.3g}", "optimal": "fastest timing"}
        title = titles.get(side, "smooth timing")
    return Clip(title, state.trajectory, state.result.range, urdfs), state.admissible
