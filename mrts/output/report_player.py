# SPDX-License-Identifier: MIT
"""The motion in three dimensions, frame by frame: arms, object and contact forces."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.plots.plot import shortened
from mrts.plots.plotly_drawer import FONT, numbers, plot_text
from mrts.scaling.scale import ScalingResult
from mrts.scene.cell_view import look_at
from mrts.scene.held_body import held_body, outlines, shape_surface
from mrts.scene.scene import FORCE, OBJECT, SEE_THROUGH, SURROUNDINGS, Rgb, Scene, arm_hex, suited_pace

MOST_FRAMES = 160
MOST_TRIANGLES = 250
"""Of the object: the page holds its corners frame by frame."""

LONGEST_ARROW = 0.22
"""The largest force, as a share of the scene."""

NO_FORCE = 1e-9
"""Forces up to this are rounding [N]."""

EYE = 1.7
"""How far a camera stands from the middle, in sides of the scene."""

MARGIN = 0.08
"""Around everything that moves, as a share of the scene."""


def player(result: ScalingResult, way: Array | None = None) -> dict[str, Any]:
    """What the page needs to play the trajectory with its forces; where there is none, the given motion.

    Args:
        result: Any result.
        way: Along the path at its samples, if known, Shape (N,).

    Returns:
        Traces ("data"), those that move first, the scene ("layout"), coordinates of the moving traces ("frames"), by
        trace, axis and frame, and their "time" [s]; the "speed" at which to begin, the "largest_force", which the
        longest arrow stands for [N], and "clocks" of plots at the frames: "given" and "played" [s], "way" if known.
    """
    cell, given, done = result.cell, result.motion.object, result.trajectory
    nowhere = np.zeros(len(given.time), dtype=bool)
    whole = Scene(cell, given.time, result.motion.q, given.position, given.rotation, nowhere)
    whole = whole if done is None else Scene.of(done)
    count = len(whole.time)
    frames = np.unique(np.linspace(0, count - 1, min(count, MOST_FRAMES)).round().astype(int))
    scene = whole.at(frames)
    arms, position, rotation = scene.lines, scene.position, scene.rotation
    vertices, triangles = body = held_body(cell, MOST_TRIANGLES)
    box = position[:, None] + np.einsum("nij,kj->nki", rotation, vertices)
    drawn = position[:, None, None] + np.einsum("nij,eaj->neai", rotation, outlines(body))
    holds = [np.stack([position, arm[:, -1]], axis=1) for arm in arms]
    segments = [*np.moveaxis(drawn, 1, 0), *holds]
    edges = np.concatenate([np.insert(segment, 2, np.nan, axis=1) for segment in segments], axis=1)
    solid = np.concatenate([*arms, box], axis=1).reshape(-1, 3)
    arrows, largest = _arrows(scene, LONGEST_ARROW * float(np.max(np.ptp(solid, axis=0)))), scene.strongest[0]
    moving = [
        (arm, _arm_trace(robot.name, index, arm.shape[1]))
        for index, (robot, arm) in enumerate(zip(cell.robots, arms, strict=True))
    ]
    moving += [
        (box, _surface_trace("object", triangles, OBJECT, 0.6)),
        (edges, _line_trace("object", "#555", 3, legend=False)),
    ]
    if largest > NO_FORCE:
        tips = {"color": f"rgb{FORCE}", "size": [0, 10, 0] * len(arms), "symbol": "diamond"}
        trace = _line_trace("force on the object", f"rgb{FORCE}", 5)
        moving.append((arrows, trace | {"mode": "lines+markers", "marker": tips}))
    path = _line_trace("path of the object", "#888", 2) | _coordinates(position)
    obstacles = [
        _surface_trace(str(one.name), faces, SURROUNDINGS, SEE_THROUGH) | _coordinates(points)
        for one in cell.surroundings
        for points, faces in [shape_surface(cell, one, MOST_TRIANGLES)]
    ]
    still = [trace | {axis: values[0] for axis, values in _coordinates(points).items()} for points, trace in moving]
    view = look_at(scene)
    eyes = {"eye": EYE * view.direction, "up": view.up}
    camera = {name: dict(zip("xyz", axis.tolist(), strict=True)) for name, axis in eyes.items()}
    clocks = {"given": given.time, "played": whole.time} | ({} if way is None else {"way": way})
    return {
        "data": [*still, path, *obstacles],
        "layout": _layout(cell, np.concatenate([solid, arrows.reshape(-1, 3)]), camera),
        "frames": [_coordinates(points) for points, _ in moving],
        "time": numbers(scene.time),
        "speed": suited_pace(float(scene.time[-1])),
        "largest_force": largest if largest > NO_FORCE else 0.0,
        "clocks": {name: numbers(clock[frames]) for name, clock in clocks.items()},
    }


def _coordinates(points: Array) -> dict[str, Any]:
    """Coordinates by axis; of a moving trace, Shape (frames, P, 3), by frame then."""
    return {axis: numbers(np.round(points[..., index], 5)) for index, axis in enumerate("xyz")}


def _arrows(scene: Scene, longest: float) -> Array:
    """Forces as lines with gaps, from a contact to a tip, the longest so long [m], Shape (frames, 3 arms, 3)."""
    point, force, _ = scene.contacts
    tip = point + longest / max(scene.strongest[0], NO_FORCE) * force
    return np.stack([point, tip, np.full_like(tip, np.nan)], axis=2).reshape(len(point), -1, 3)


def _arm_trace(name: str, index: int, points: int) -> dict[str, Any]:
    colour = arm_hex(index)
    symbols = ["square", *["circle"] * (points - 2), "diamond"]
    return {
        "type": "scatter3d",
        "mode": "lines+markers",
        "name": plot_text(shortened(name)),
        "line": {"color": colour, "width": 9},
        "marker": {"color": colour, "size": [7, *[5] * (points - 2), 4], "symbol": symbols},
        "hoverinfo": "name",
    }


def _surface_trace(name: str, triangles: NDArray[np.int64], colour: Rgb, opacity: float) -> dict[str, Any]:
    i, j, k = triangles.T.tolist()
    return {
        "type": "mesh3d",
        "name": plot_text(shortened(name)),
        "i": i,
        "j": j,
        "k": k,
        "color": f"rgb{colour}",
        "opacity": opacity,
        "flatshading": True,
        "hoverinfo": "name",
    }


def _line_trace(name: str, colour: str, width: int, *, legend: bool = True) -> dict[str, Any]:
    return {
        "type": "scatter3d",
        "mode": "lines",
        "name": name,
        "line": {"color": colour, "width": width},
        "hoverinfo": "skip",
        "showlegend": legend,
    }


def _layout(cell: Cell, points: Array, camera: dict[str, Any]) -> dict[str, Any]:
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    margin = MARGIN * float(np.max(high - low))
    low, high = low - margin, high + margin
    axes: dict[str, Any] = {}
    for index, axis in enumerate("xyz"):
        axes[f"{axis}axis"] = {
            "title": {"text": f"{axis} [m]"},
            "range": numbers(np.array([low[index], high[index]])),
            "tickangle": 0,
            "visible": cell.plane is None or axis in cell.plane,
            "gridcolor": "#ddd",
            "zerolinecolor": "#bbb",
        }
    ratio = dict(zip("xyz", numbers(high - low), strict=True))
    return {
        "font": FONT,
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "paper_bgcolor": "#fff",
        "legend": {"orientation": "h", "x": 0, "y": 1, "yanchor": "top"},
        "modebar": {"orientation": "v"},
        "scene": axes | {"aspectmode": "manual", "aspectratio": ratio, "camera": camera},
        "uirevision": "kept",
    }
