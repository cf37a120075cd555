"""Seeded random programs of the structure that cells give, and hard ones made by hand."""

import numpy as np


def skew(v):
    S = np.zeros((*v.shape[:-1], 3, 3))
    S[..., 0, 1], S[..., 0, 2], S[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return S - np.swapaxes(S, -1, -2)


def cell_programs(rng, count, arms, size):
    """Rows of the wrench form at `count` samples that change slowly: A, lower, upper over [F_1 … F_{n-1}, c²].

    Jacobians are random matrices, grasp maps those of random contact points; limits are 1 in their unit.
    """
    t = np.linspace(0, 1, count)[:, None, None, None]
    shape = (1, arms, size, size)
    J = rng.normal(size=shape) + 0.3 * t * rng.normal(size=shape)
    B = np.tile(np.eye(size), (count, arms, 1, 1))
    r = rng.uniform(-0.4, 0.4, (1, arms, 3)) + 0.1 * t[..., 0] * rng.normal(size=(1, arms, 3))
    if size == 6:
        B[:, :, 3:, :3] = skew(r)
    else:
        B[:, :, 2, 0], B[:, :, 2, 1] = -r[..., 1], r[..., 0]
    now = t[:, 0, 0, 0]
    wave = np.sin(np.pi * now * rng.uniform(0.5, 2))[:, None]
    P = rng.normal(size=size) * 3 * (1 + wave)
    Q = rng.normal(size=size) * rng.uniform(0.1, 6)
    E = rng.normal(size=(arms * size,)) * 4 * np.cos(3 * now)[:, None]
    G = rng.normal(size=(arms * size,)) * rng.uniform(0.1, 4) + wave
    free = size * (arms - 1)
    last = np.linalg.inv(B[:, -1])
    maps = np.zeros((count, arms * size, free + 1))
    maps[:, :free, :free] = np.eye(free)
    maps[:, free:, :free] = -last @ np.concatenate(
        [B[:, i] for i in range(arms - 1)] + [np.zeros((count, size, 0))], axis=2
    )
    maps[:, free:, -1] = np.einsum("nij,nj->ni", last, P)
    offset = np.zeros((count, arms * size))
    offset[:, free:] = last @ Q
    torque_map, torque_offset = np.zeros_like(maps), G.copy()
    for i in range(arms):
        part = slice(i * size, (i + 1) * size)
        torque_map[:, part] = np.swapaxes(J[:, i], 1, 2) @ maps[:, part]
        torque_offset[:, part] += np.einsum("nij,nj->ni", np.swapaxes(J[:, i], 1, 2), offset[:, part])
    torque_map[:, :, -1] += E
    torque = np.tile(rng.choice([0.3, 1.0, 3.0]) * rng.uniform(2, 12, arms * size), (count, 1))
    wrench = rng.uniform(1, 20, arms * size)
    wrench[rng.random(arms * size) < 0.3] = np.inf
    lower_wrench = np.where(rng.random(arms * size) < 0.15, -np.inf, -wrench)
    keep = np.isfinite(wrench) | np.isfinite(lower_wrench)
    unit = np.concatenate([torque[0], np.where(np.isfinite(wrench), wrench, 1)[keep]])
    A = np.concatenate([torque_map, maps[:, keep]], axis=1)
    lower = np.concatenate([-torque - torque_offset, (lower_wrench - offset)[:, keep]], axis=1)
    upper = np.concatenate([torque - torque_offset, (wrench - offset)[:, keep]], axis=1)
    return A / unit[:, None], lower / unit, upper / unit


def hard_programs(rng, k, rows):
    """Programs by kind: A, lower, upper, feasible by construction (None: unknown)."""

    def boxed(width=1.0):
        A = rng.normal(size=(rows, k))
        x = rng.normal(size=k)
        x[-1] = abs(x[-1])
        slack = width * rng.random((2, rows))
        return A, A @ x - slack[0], A @ x + slack[1], x

    kinds = {}
    A, lower, upper, x = boxed()
    upper[: 2 * k] = (A @ x)[: 2 * k]  # many limits through one point
    kinds["degenerate vertex"] = A, lower, upper, True
    A, lower, upper, _ = boxed()
    A[1], lower[1], upper[1] = 2 * A[0], 2 * lower[0] - 1e-12, 2 * upper[0]
    A[2], lower[2], upper[2] = -A[0], -upper[0], -lower[0]
    A[3] = A[0] + 1e-9 * rng.normal(size=k)
    lower[3], upper[3] = lower[0] - 1, upper[0] + 1
    kinds["parallel rows"] = A, lower, upper, True
    A, lower, upper, x = boxed()
    fixed = np.arange(min(3, k - 1))
    lower[fixed] = upper[fixed] = (A @ x)[fixed]
    kinds["equations"] = A, lower, upper, True
    A, lower, upper, x = boxed()
    A[0], lower[0], upper[0] = 0, -1, 1
    A[1], lower[1], upper[1] = 0, 0, 0
    A[:, 0] = 0  # an unknown that nothing limits
    kinds["empty rows and columns"] = A, np.minimum(lower, A @ x), np.maximum(upper, A @ x), True
    A, lower, upper, x = boxed(0.0)
    kinds["a single point"] = A, lower, upper, True
    A, lower, upper, x = boxed()
    lower[0] = -np.inf
    upper[1] = np.inf
    A[2], lower[2], upper[2] = A[0], upper[0] + 1e-6, np.inf
    kinds["infeasible by 1e-6"] = A, lower, upper, False
    A, lower, upper, _ = boxed()
    A[rows // 2 :] = A[: rows - rows // 2] @ np.diag(np.where(np.arange(k) % 2, 1.0, 0.0)) + A[rows // 2 :] * 0
    kinds["rank deficient"] = A, lower, upper, None
    A, lower, upper, _ = boxed()
    scale = 10.0 ** rng.uniform(-6, 6, k)
    kinds["scales of 1e-6 to 1e6"] = A * scale, lower, upper, True
    A, lower, upper, _ = boxed()
    kinds["small integers"] = np.round(A), np.floor(lower), np.ceil(upper), None
    return kinds
