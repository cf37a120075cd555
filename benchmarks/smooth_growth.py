# SPDX-License-Identifier: MIT
"""How smooth timing grows with points, arms and corners of a box of loads: whole calls, each in a process of its own.

Torque rates of 11 times the torque limit a second, and wrench limits where there is more than one arm; the object rises
by 50 mm. Points are those that are asked for: none is added between them. CPU time of the first call once the cell is
compiled, and peak memory of the process, of which Python, numpy and the cell take some 100 MB.
"""

import resource
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from cases import ring, shipped, straight_up

import mrts

RATE = 11.0
BOX = {"mass": (0.9, 1.1), "mx": (-0.1, 0.1), "my": (-0.1, 0.1)}
POINTS, ARMS, CORNERS = (100, 300, 1000, 3000), (1, 2, 3, 4), (1, 2, 4, 8)
USUAL = 300
"""Points where something else grows."""


def asked(points: int, arms: int, corners: int) -> tuple[float, float, float, int]:
    """CPU time of a call [s], peak memory [MB], duration [s] and corners with which the timing was found."""
    with tempfile.TemporaryDirectory() as folder:
        cell = ring(Path(folder), arms)
    if corners > 1:
        cell = cell.with_variation(**dict(list(BOX.items())[: corners.bit_length() - 1]))
    _, few = shipped("dual_ur5", 101)
    motion = mrts.follow_object(cell, straight_up(few.object, points))
    mrts.retime(cell, mrts.follow_object(cell, straight_up(few.object, 11)), rates=RATE, between=None)
    start = time.process_time()
    found = mrts.retime(cell, motion, rates=RATE, between=None)
    taken = time.process_time() - start
    if found.duration is None:
        raise RuntimeError(found.explanation)
    return taken, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000, found.duration, len(found.loads)


def main(
    points: tuple[int, ...] = POINTS,
    arms: tuple[int, ...] = ARMS,
    corners: tuple[int, ...] = CORNERS,
    usual: int = USUAL,
) -> None:
    """Print the growth with each."""
    cases = {
        "points, two arms": [(number, 2, 1) for number in points],
        f"arms, {usual} points": [(usual, number, 1) for number in arms],
        f"corners, two arms, {usual} points": [(usual, 2, number) for number in corners],
    }
    for what, each in cases.items():
        print(f"smooth timing, growth with the number of {what}")
        for case in each:
            with ProcessPoolExecutor(1, get_context("spawn")) as alone:
                taken, memory, duration, loads = alone.submit(asked, *case).result()
            print(
                f"  {case[0]:>5} points, {case[1]} arms, {loads:>2} loads{1e3 * taken:>9.0f} ms"
                f"{1e6 * taken / case[0]:>8.0f} µs a point{memory:>7.0f} MB   ({duration:.6f} s)",
                flush=True,
            )


if __name__ == "__main__":
    main()
