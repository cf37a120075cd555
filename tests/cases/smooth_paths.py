"""Seeded random paths for smooth timing, each with a profile that keeps its limits with room to spare."""

from dataclasses import replace

import numpy as np

from mrts.program.smooth_program import SmoothProfile, SmoothProgram, segment_times


def waves(rng, s, shape, size=1.0):
    """Smooth functions of s, random numbers at 0 and three waves: Shape (len(s), *shape)."""
    total = rng.normal(size=shape) * size * np.ones((len(s), *shape))
    for wave in range(1, 4):
        amplitude, phase = rng.normal(size=shape) * size / wave, rng.uniform(0, 2 * np.pi, shape)
        total += amplitude * np.sin(np.pi * wave * s.reshape(-1, *(1 for _ in shape)) + phase)
    return total


def smooth_path(rng, n, *, rows, free=0, blocks=1, changes=True, roots=False, joints=0, cones=0, loose=0.7):
    """A program with n nodes, and a profile that uses a share `loose` of its limits at most.

    Blocks are corners of a box of loads, each with rows and `free` columns of its own. Changes of rows may be limited,
    rows have terms with the root of x, joints limited jerk.
    """
    s = np.linspace(0, 1, n)
    step = np.diff(s)
    control = 1 + 0.3 * rng.uniform(-1, 1) * np.sin(np.pi * rng.uniform(0.5, 1) * np.linspace(0, 1, n + 1))
    h = np.concatenate([[0], step, [0]])
    total = h[:-1] + h[1:]
    x = (h[1:] * control[:-1] + h[:-1] * control[1:]) / total
    u = np.diff(control) / total
    r, f = rows * blocks, free * blocks
    square, rate = (np.tile(waves(rng, s, (rows,)), (1, blocks)) for _ in range(2))
    square, rate = square * (1 + 0.1 * waves(rng, s, (r,))), 0.2 * rate * (1 + 0.1 * waves(rng, s, (r,)))
    root = 0.3 * waves(rng, s, (r,)) if roots else np.zeros((n, r))
    entry = np.zeros((n, r, f))
    for block in range(blocks):
        part = slice(block * rows, (block + 1) * rows), slice(block * free, (block + 1) * free)
        entry[:, *part] = waves(rng, s, (rows, free))
    single = min(free, rows // 4)
    for row in range(single if blocks == 1 else 0):  # limits of one unknown
        entry[:, row] = 0.0
        entry[:, row, row] = 1.0
    force = waves(rng, s, (f,), 0.3)
    program = SmoothProgram(
        step=step, square=square, rate=rate, root=root, offset=waves(rng, s, (r,)), free=entry,
        lower=np.full((n, r), -np.inf), upper=np.full((n, r), np.inf), change=np.full(r, np.inf),
        weight=rng.uniform(0.2, 2, r), sizes=np.zeros((2, r)), q1=waves(rng, s, (joints,)), q2=waves(rng, s, (joints,)),
        q3=waves(rng, np.linspace(0, 1, 2 * (n - 1)), (joints,)).reshape(n - 1, 2, joints), jerk=np.ones(joints),
        gram=np.zeros((n, 0, 3, 3)), bound=np.zeros((n, 0, 3)),
    )  # fmt: skip
    values = program.values(x, u, force)
    middle, half = (values.max(0) + values.min(0)) / 2, (values.max(0) - values.min(0)) / 2 + 0.1
    unit = (np.abs(middle) + half) / loose
    lower, upper = (middle - half / loose) / unit, (middle + half / loose) / unit
    program = replace(
        program, square=square / unit, rate=rate / unit, root=root / unit, offset=program.offset / unit,
        free=entry / unit[:, None], lower=np.tile(lower, (n, 1)), upper=np.tile(upper, (n, 1)),
        jerk=np.max(np.abs(program.jerks(x, u)), axis=(0, 1), initial=0.1) / loose,
    )  # fmt: skip
    program.lower[:, rng.random(r) < 0.15] = -np.inf
    if changes:
        moved = np.max(
            np.abs(np.diff(program.values(x, u, force), axis=0)) / segment_times(program.step, x)[:, None], axis=0
        )
        change = (moved + 0.2) / loose
        change[rng.random(r) < 0.2] = np.inf
        program = replace(program, change=change)
    if cones:
        left, right = waves(rng, s, (cones, 3, 3), 0.5), waves(rng, s, (cones, 3), 0.1)
        z = np.column_stack([u, x, np.ones(n)])[:, None]
        size = np.linalg.norm(np.sum(left * z[:, :, None], axis=3), axis=2) / loose
        right[:, :, 2] += size - np.sum(right * z, axis=2)
        left, right = left / size.max(0)[:, None, None], right / size.max(0)[:, None]
        program = replace(program, gram=left.transpose(0, 1, 3, 2) @ left, bound=right)
    return program, SmoothProfile(x, u, force)
