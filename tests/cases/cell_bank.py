"""Random cells on a fixed bank of structures: each is generated once, and limits, object and motion are drawn on it."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pinocchio as pin
import yaml
from random_cells import (
    PLANES,
    Structure,
    planar_pose,
    planar_structure,
    random_inertia,
    spatial_pose,
    spatial_structure,
)

import mrts
from mrts.base.load_box import load_vector

ARMS = (1, 2, 3, 4)
PLANAR = {f"{plane}_{arms}": (plane, arms) for plane in PLANES for arms in ARMS}
SPATIAL = {f"spatial_{arms}_{number}": (arms, number) for arms in ARMS for number in (0, 1)}
"""The bank, 20 structures in all, because each costs up to 15 s to generate and compile."""

PROFILES = ("sinusoid", "trapezoid", "cubic", "quintic")


@dataclass(frozen=True)
class RandomCell:
    """A cell and a motion of the object, and the files that say the same."""

    cell: mrts.Cell
    motion: mrts.ObjectMotion
    cell_file: Path
    motion_file: Path


def random_planar_cell(rng, folder: Path, arms: int, samples: int = 11) -> RandomCell:
    """A planar cell of the bank with other limits, another object and another motion."""
    plane = str(rng.choice(list(PLANES)))
    name = f"{plane}_{arms}"
    position, angle = structure(name).start
    position, angle = position + rng.uniform(-0.03, 0.03, 2), angle + rng.uniform(-0.08, 0.08)
    ends = {
        "start": planar_pose(plane, position, angle),
        "end": planar_pose(plane, position + rng.uniform(-0.06, 0.06, 2), angle + rng.uniform(-0.15, 0.15)),
    }
    motion = random_timing(rng, (0.15, 1.2), samples) | ends
    robots = []
    for robot in structure(name).description["robots"]:
        torque = rng.choice([0.6, 1.5, 5.0]) * rng.uniform([40, 25, 6], [90, 50, 15])
        posture = robot["posture"] + rng.uniform(-0.05, 0.05, 3)
        limits = {"torque": torque.tolist(), "posture": posture.tolist()}
        robots.append(robot | limits | random_wrench_limits(rng, 1, 40, 3))
    return drawn(rng, name, robots, motion, folder)


def random_spatial_cell(rng, folder: Path, arms: int, samples: int = 11) -> RandomCell:
    """A spatial cell of the bank with other limits, another object and another motion."""
    name = f"spatial_{arms}_{rng.integers(2)}"
    start = structure(name).start
    start = pin.SE3(start.rotation @ pin.exp3(rng.uniform(-0.02, 0.02, 3)),
                    start.translation + rng.uniform(-0.006, 0.006, 3))  # fmt: skip
    step = rng.uniform(-0.012, 0.012, 3)
    end = pin.SE3(start.rotation @ pin.exp3(rng.uniform(-0.05, 0.05, 3)), start.translation + step)
    motion = random_timing(rng, (0.1, 0.6), samples) | {"start": spatial_pose(start), "end": spatial_pose(end)}
    robots = []
    for robot in structure(name).description["robots"]:
        torque = rng.choice([1.0, 2.5, 8.0]) * rng.uniform(10, 40, len(robot["posture"]))
        robots.append(robot | {"torque": torque.tolist()} | random_wrench_limits(rng, 2, 60, 6))
    return drawn(rng, name, robots, motion, folder)


def drawn_until(suits, draw):
    """What the first of some draws that suits is, and what `suits` found: None of a draw that does not."""
    while True:
        case = draw()
        found = suits(case)
        if found is not None:
            return case, found


def random_timing(rng, durations, samples):
    """Duration [s], samples and profile of a motion file."""
    return {"duration": float(rng.uniform(*durations)), "samples": samples, "profile": str(rng.choice(PROFILES))}


def random_wrench_limits(rng, low, high, size):
    """Mostly limits on some components; sometimes none at all."""
    if rng.random() >= 0.6:
        return {}
    bounds = rng.uniform(low, high, size)
    lower = [None if rng.random() < 0.4 else -float(b) for b in bounds]
    return {"wrench": {"lower": lower, "upper": [None if rng.random() < 0.4 else float(b) for b in bounds]}}


def drawn(rng, name, robots, motion, folder) -> RandomCell:
    """The structure with these limits and a random object, as a cell and as files."""
    mass = rng.uniform(0.2, 6)
    inertia = random_inertia(rng, mass, 0.2)
    speeds = rng.uniform(0.5, 2, len(robots))
    carried = {"mass": mass, "inertia": inertia.tolist()}
    description = structure(name).description | {"name": name, "object": carried, "robots": robots}
    urdfs = {
        file: text.replace('velocity="1"', f'velocity="{speed:.17g}"')
        for (file, text), speed in zip(structure(name).urdfs.items(), speeds, strict=True)
    }
    cell_file = write_cell(folder, description, urdfs)
    motion_file = folder / "motion.yaml"
    motion_file.write_text(yaml.safe_dump(motion), encoding="utf-8")
    cell = structure_cell(name).with_load(load_vector(mass, np.zeros(3), inertia))
    ours = [with_limits(*pair, speed) for *pair, speed in zip(cell.robots, robots, speeds, strict=True)]
    return RandomCell(replace(cell, robots=tuple(ours)), mrts.load_motion(motion_file), cell_file, motion_file)


def with_limits(robot, described, speed):
    """A robot with the limits and posture of its entry in a cell file, and one velocity limit for its joints."""
    wrench = described.get(
        "wrench", {"lower": [None] * len(robot.wrench_lower), "upper": [None] * len(robot.wrench_lower)}
    )
    torque = np.array(described["torque"])
    return replace(
        robot,
        posture=np.array(described["posture"]),
        velocity_limit=np.full(len(robot.joints), speed),
        torque_lower=-torque,
        torque_upper=torque,
        wrench_lower=np.array([-np.inf if limit is None else limit for limit in wrench["lower"]]),
        wrench_upper=np.array([np.inf if limit is None else limit for limit in wrench["upper"]]),
    )


@cache
def structure(name: str) -> Structure:
    """A structure of the bank."""
    if name in PLANAR:
        return planar_structure(np.random.default_rng([list(PLANAR).index(name)]), *PLANAR[name])
    arms, number = SPATIAL[name]
    return spatial_structure(np.random.default_rng([arms, number]), arms)


def bare_cell(name: str, folder: Path) -> Path:
    """A structure with some object, as files."""
    bare = {"name": name, "object": {"mass": 1.0, "inertia": [1.0, 1.0, 1.0]}}
    return write_cell(folder, structure(name).description | bare, structure(name).urdfs)


@cache
def structure_cell(name: str) -> mrts.Cell:
    """The cell of a structure; what another process compiled for it comes from the cache of the tests."""
    with TemporaryDirectory() as folder:
        return replace(mrts.load_cell(bare_cell(name, Path(folder))), folder=None)


def write_cell(folder, description, urdfs) -> Path:
    """A cell file and its URDFs."""
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in urdfs.items():
        (folder / file).write_text(text, encoding="utf-8")
    path = folder / "cell.yaml"
    path.write_text(yaml.safe_dump(description), encoding="utf-8")
    return path
