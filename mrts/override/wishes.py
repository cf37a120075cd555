# SPDX-License-Identifier: MIT
"""Speeds that are wanted while a plan is played, and what its override makes of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from mrts.base.argument_types import as_path
from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array
from mrts.following.coordinated_motion import carried_by_first
from mrts.motion.csv_motion import read_columns, row_times
from mrts.motion.rows_at_rest import pushing_ends
from mrts.override.speed_override import SpeedOverride
from mrts.scaling.scaled_trajectory import Holding, ScaledTrajectory

COLUMNS = ("t", "speed")
"""Of a table of wishes."""

SETTLING = 10.0
"""Time after the last wish in which a wanted speed is reached [s]: cells take a hundredth of it, some within rates a
tenth."""

MOST_TICKS = 100_000
"""Of a run: a hundred seconds at 1 kHz."""

DRAWN = 20
"""Wishes of a random run, each held for about a tenth of the plan."""


def read_wishes(path: Path | str) -> Array:
    """Read a CSV table with the columns t [s] and speed: times from 0 and speeds, each held until the next, (k, 2).

    Raises:
        InputError: If it is malformed, says where.
    """
    path = as_path("path", path)
    columns = read_columns(path, least=1)
    if unknown := set(columns) - set(COLUMNS):
        raise InputError(path, f"unknown column '{min(unknown)}'. Columns are {', '.join(COLUMNS)}.")
    if "speed" not in columns:
        raise InputError(path, "a column 'speed' is needed: 1 as planned, 0 to stop.")
    return np.column_stack([row_times(path, columns), columns["speed"]])


def random_wishes(seed: int, duration: float) -> Array:
    """Steps, ramps and stops for about twice a duration [s], then 1, Shape (k, 2)."""
    rng = np.random.default_rng(seed)
    rows, now = list[tuple[float, float]](), 0.0
    for kind in rng.choice(["step", "ramp", "stop"], DRAWN, p=[0.4, 0.3, 0.3]):
        held = float(rng.uniform(0.02, 0.2)) * duration
        before = rows[-1][1] if rows else 0.0
        after = 0.0 if kind == "stop" else float(rng.uniform(0.0, 1.0))
        steps = 10 if kind == "ramp" else 1
        rows += [(now + held * k / steps, before + (after - before) * (k + 1) / steps) for k in range(steps)]
        now += held
    return np.array([*rows, (now, 1.0)])


def commanded(override: SpeedOverride, wanted: Array, dt: float) -> ScaledTrajectory:
    """What a controller commands at every tick of dt [s], when some speed is wanted, Shape (k,), until nothing moves.

    At the start the first speed is had.

    Raises:
        InputError: If nothing moves, or something still does at the last tick.
    """
    start = override.start(0.0, min(max(float(wanted[0]), 0.0), 1.0))
    states = np.concatenate([start.numbers.reshape(1), override.play(wanted, dt, start)])
    moves = np.flatnonzero(states["speed"][1:])
    if not moves.size:
        raise InputError("override", "never leaves the start of the plan: some wanted speed must be > 0.")
    if moves[-1] + 1 == len(wanted):
        raise InputError("override", f"still moves after {dt * len(wanted):.4g} s.")
    played = states[: moves[-1] + 3]
    q, dq, ddq, torque, wrench = (np.array(played[name]) for name in ("q", "dq", "ddq", "torque", "wrench"))
    time = dt * np.arange(len(played), dtype=np.float64)
    ahead = np.sign(np.diff(override.nodes["q"], axis=0))[played["node"]] * played["direction"][:, None]
    way = np.where(dq != 0, np.sign(dq), ahead)
    carried = carried_by_first(override.cell, time, q, dq, ddq)
    motion, still = replace(carried, travel=np.stack([way, way])), override.start(0.0)
    held = Holding(pushing_ends(dq, ddq), np.stack([still.torque, torque[-1]]), np.stack([still.wrench, wrench[-1]]))
    return ScaledTrajectory(override.cell, motion, 1.0, torque, wrench, held)


def wanted_at_ticks(wishes: Array, duration: float, dt: float) -> Array:
    """The speed wanted at every tick of dt [s] of a plan until what the last wish asks for is reached, Shape (k,).

    Raises:
        InputError: If wishes are malformed, or that takes more than `MOST_TICKS`.
    """
    given = as_array("override", wishes)
    if given.ndim != 2 or given.shape[1:] != (2,) or not len(given) or not np.all(np.isfinite(given)):  # noqa: PLR2004
        raise InputError("override", "must have Shape (k, 2): times and wanted speeds, all finite.")
    time, speed = given.T
    if np.max(np.abs(speed)) > 1:
        raise InputError(
            "override", "wants speeds up to 1, the plan's own.", value=float(speed[np.argmax(np.abs(speed))])
        )
    if time[0] != 0 or np.any(np.diff(time) <= 0):
        raise InputError("override", "must have times from 0 on that increase.", value=time.tolist())
    last = abs(float(speed[-1]))
    left = SETTLING + (duration / last if last > duration / (MOST_TICKS * dt) else 0.0)
    ticks = np.ceil((time[-1] + left) / dt)
    if ticks > MOST_TICKS:
        raise InputError("override", f"lasts more than {MOST_TICKS} ticks of {dt:g} s.", value=float(time[-1]))
    return np.asarray(speed[np.searchsorted(time, dt * (np.arange(ticks) + 1.5), side="right") - 1])
