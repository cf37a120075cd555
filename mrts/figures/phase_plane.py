# SPDX-License-Identifier: MIT
"""The phase plane of a retimed path; needs the extra 'plot' (matplotlib)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mrts.drawing.colours import COLOURS
from mrts.retiming.result import RetimingResult
from mrts.retiming.retimed_motion import FastestPiece

HEADROOM = 1.35
"""The maximum velocity curve goes out of the picture above this multiple of the profile."""


def phase_plane_figure(found: RetimingResult) -> Figure:
    """Speed along the path: the maximum velocity curve, the fastest profile, and the best constant factor.

    Args:
        found: A result with a profile.

    Raises:
        ValueError: If there is none.
    """
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    figure.suptitle(f"{found.cell.name}: speed along the path", fontsize="medium")
    draw_phase_plane(figure.subplots(), found)
    return figure


def draw_phase_plane(axes: Axes, found: RetimingResult) -> None:
    """The same into axes of yours.

    Args:
        axes: Where.
        found: A result with a profile.

    Raises:
        ValueError: If there is none.
    """
    pieces = [part for part in found.pieces if isinstance(part, FastestPiece)]
    if not pieces:
        raise ValueError("there is no profile to draw")
    before, top = 0.0, 0.0
    best = found.constant.trajectory
    for number, part in enumerate(pieces):
        s = before + part.piece.path.object.time
        before = float(s[-1])
        most = np.sqrt(np.where(np.isfinite(part.regions.upper), part.regions.upper, np.nan))
        speed, controllable = np.sqrt(part.profile.x), np.sqrt(part.profile.upper)
        labels = [
            "maximum velocity curve" if _in_view(pieces) else "_",
            "controllable",
            f"fastest, {found.duration:.4g} s",
            "" if best is None else f"best constant c, {best.duration:.4g} s",
        ]
        labels = [label if number == 0 else "_" for label in labels]
        axes.plot(s, most, color=COLOURS[6], linewidth=1, linestyle=":", label=labels[0])
        axes.fill_between(s, np.sqrt(part.profile.lower), controllable, color=COLOURS[2], alpha=0.15, label=labels[1])
        axes.plot(s, speed, color=COLOURS[1], label=labels[2])
        top = max(top, float(np.max(speed)))
        if best is not None:
            constant = best.c * part.piece.speed
            axes.plot(s, constant, color=COLOURS[0], linestyle="--", label=labels[3])
            top = max(top, float(np.max(constant)))
        if number > 0:
            axes.axvline(float(s[0]), color=COLOURS[6], alpha=0.3, linewidth=1)
    axes.set_ylim(0, HEADROOM * top)
    axes.margins(x=0)
    axes.set_xlabel("path s (root mean square of the joints' way) [rad or m]")
    axes.set_ylabel("speed ṡ [rad/s or m/s]")
    axes.legend()
    axes.grid(visible=True, alpha=0.3)


def _in_view(pieces: list[FastestPiece]) -> bool:
    """Whether some of the maximum velocity curve is within the picture."""
    top = max(float(np.max(part.profile.x)) for part in pieces)
    return any(bool(np.any(part.regions.upper <= HEADROOM**2 * top)) for part in pieces)
