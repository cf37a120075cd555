# SPDX-License-Identifier: MIT
"""Random cells and motions as files, with the questions that are asked of them.

Only joints and links of the arms are compiled into a cell, so a bank of some 27 structures carries any number of cases:
where arms stand and hold, limits, hands, motors, load and motion are drawn for each.
"""

import json
import re
import sys
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pinocchio as pin
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "cases"))
from answers import BLOCK
from cell_bank import PROFILES, random_wrench_limits
from conftest import ROOT
from damaged_cells import HINTS, MISTAKES
from motion_tables import QUATERNION_NAMES, write_table
from random_cells import (
    PLANES,
    Structure,
    chain_model,
    configuration,
    planar_structure,
    random_inertia,
    spatial_pose,
    spatial_structure,
)

BANK: tuple[tuple[Any, ...], ...] = (
    ("xy", 2), ("dual_ur5", 2), ("spatial", 1, 6, 0), ("squeeze", 2), ("xz", 1), ("spatial", 2, 7, 0), ("xy", 3),
    ("planar_dual_arm", 2), ("spatial", 2, 6, 0), ("uncertain_load", 2), ("yz", 4), ("upper_body", 2),
    ("spatial", 3, 6, 0), ("dual_ur5", 1), ("xz", 2), ("redundant", 2), ("spatial", 4, 6, 0), ("xy", 1),
    ("redundant", 1), ("spatial", 2, 6, 1), ("yz", 3), ("three_arms", 3), ("spatial", 1, 7, 0), ("xy", 4),
    ("spatial", 3, 7, 0), ("yz", 2), ("spatial", 4, 6, 1),
)  # fmt: skip
"""Planar arms in a plane, spatial arms (with how many joints, and a number), and the first arms of shipped cells."""


@cache
def structure(place: int) -> tuple[Structure, list[Any]]:
    """A structure of the bank, its start as a transform, and Pinocchio's model of each arm."""
    kind, arms, *more = BANK[place]
    if kind in PLANES:
        found = planar_structure(np.random.default_rng([arms, ord(kind[0])]), kind, arms)
        found.start = in_plane(kind, *found.start)
    elif kind == "spatial":
        found = spatial_structure(np.random.default_rng([arms, *more]), arms, more[0])
    else:
        found = shipped(kind, arms)
    with TemporaryDirectory() as folder:
        for name, text in found.urdfs.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        robots = found.description["robots"]
        return found, [chain_model(Path(folder) / robot["urdf"], robot["tip_link"]) for robot in robots]


def shipped(name: str, arms: int) -> Structure:
    """The first arms of a shipped cell, where its motion starts."""
    folder = ROOT / "mrts" / "data" / name
    motion = yaml.safe_load(next(folder.glob("lift*.yaml")).read_text(encoding="utf-8"))
    description, urdfs = yaml.safe_load((folder / "cell.yaml").read_text(encoding="utf-8")), {}
    description["robots"] = description["robots"][:arms]
    for robot in description["robots"]:
        path = folder / robot["urdf"]
        robot["urdf"], urdfs[path.name] = path.name, path.read_text(encoding="utf-8")
    return Structure(description, urdfs, frame(motion["start"]))


def frame(pose: dict[str, Any]) -> Any:
    """A pose of a file as a transform."""
    return pin.SE3(pin.rpy.rpyToMatrix(*map(float, pose.get("rpy", (0, 0, 0)))), np.array(pose["xyz"], dtype=float))


def in_plane(plane: str, position: Any, angle: float) -> Any:
    """A transform within a plane."""
    first, second, normal, handed = PLANES[plane]
    xyz, turn = np.zeros(3), np.zeros(3)
    xyz[[first, second]], turn[normal] = position, handed * angle
    return pin.SE3(pin.exp3(turn), xyz)


def tip(model: Any, robot: dict[str, Any], q: Any) -> tuple[Any, Any]:
    """Pose of an arm's tip in its base, and the Jacobian there in tip axes."""
    data, place = model.createData(), model.getFrameId(robot["tip_link"])
    J = pin.computeFrameJacobian(model, data, configuration(model, q), place)
    pin.framesForwardKinematics(model, data, configuration(model, q))
    return data.oMf[place].copy(), J


class Draw:
    """One case: what is drawn from a seed and a number.

    Attributes:
        cell: Of the cell file.
        urdfs: Texts by file name.
        motion: Of the motion file.
        table: Columns of a CSV file beside it, or nothing.
    """

    def __init__(self, seed: int, number: int) -> None:
        self.rng = np.random.default_rng([seed, number])
        found, self.models = structure(number // BLOCK % len(BANK))
        self.plane = found.description.get("plane")
        self.random = found.description.get("name") is None
        factor = self.rng.choice([0.5, 1, 2, 10])
        faster = (lambda limit: f'velocity="{factor * float(limit[1]):.17g}"') if self.random else "\\g<0>"
        self.urdfs = {name: re.sub(r'velocity="([^"]+)"', faster, text) for name, text in found.urdfs.items()}
        self.cell = json.loads(json.dumps(found.description | {"name": f"case{number}"}))
        self.table: dict[str, Any] = {}
        self._places(found.start)
        self._limits()
        self._load()
        self.motion = self._motion()
        arms_of_mistakes = 2
        if len(self.models) == arms_of_mistakes and "end" in self.motion and self.chance(0.25):
            self._mistake()

    def chance(self, share: float) -> bool:
        """Whether something happens."""
        return bool(self.rng.random() < share)

    def moved(self, size: float, turn: float) -> Any:
        """A random small transform, within the plane of a planar cell."""
        if self.plane:
            return in_plane(self.plane, self.rng.uniform(-size, size, 2), self.rng.uniform(-turn, turn))
        return pin.SE3(pin.exp3(self.rng.uniform(-turn, turn, 3)), self.rng.uniform(-size, size, 3))

    def _places(self, start: Any) -> None:
        """Postures, bases and grasps that reach the start; few of them near a singularity."""
        self.start = start * self.moved(0.1, 0.3)
        bases, around = self.chance(0.3) and not self.random, self.chance(0.3)
        for index, (robot, model) in enumerate(zip(self.cell["robots"], self.models, strict=True)):
            q = np.array(robot["posture"]) + self.rng.uniform(-0.1, 0.1, len(robot["posture"]))
            if self.chance(0.05):
                others = q + self.rng.uniform(-1.5, 1.5, (100, len(q)))
                q = max(others, key=lambda one: np.linalg.cond(tip(model, robot, one)[1][self.components()]))
            reached, grasp = tip(model, robot, q)[0], frame(robot["grasp"])
            if bases:
                grasp = self.start.inverse() * frame(robot["base"]) * reached
            elif around:
                turn = 2 * np.pi * index / len(self.models) + self.rng.uniform(-0.2, 0.2)
                place = self.rng.uniform(0.1, 0.4) * np.array([np.cos(turn), np.sin(turn)])
                grasp.translation = in_plane(self.plane or "xy", place, 0.0).translation
            base = self.start * grasp * reached.inverse()
            robot |= {"posture": q.tolist(), "base": spatial_pose(base), "grasp": spatial_pose(grasp)}

    def components(self) -> list[int]:
        """Places of the wrench components of the cell in a spatial vector."""
        if self.plane is None:
            return list(range(6))
        first, second, normal, _ = PLANES[self.plane]
        return [first, second, 3 + normal]

    def _limits(self) -> None:
        """Torques, wrenches, hands, motors, rates."""
        size = len(self.components())
        hands, motors, level = self.chance(0.5), self.chance(0.3), self.rng.choice([0.4, 1, 2.5, 8])
        keep = not self.random and self.chance(0.5)
        for robot in self.cell["robots"]:
            joints = len(robot["posture"])
            usual = np.linspace(*((60, 10) if self.plane else (65, 65) if self.random else (150, 28)), joints)
            torque = (level if self.random else max(level, 1) ** 0.5) * self.rng.uniform(0.5, 1.5, joints) * usual
            robot["torque"] = torque.tolist()
            if not keep:
                robot.pop("wrench", None), robot.pop("contact", None)
                robot.update(random_wrench_limits(self.rng, 3, 120, size))
                if hands:
                    robot["contact"] = [self._hand(robot)]
            if motors:
                robot["motors"] = self._motors(torque)
            if self.chance(0.15):
                robot["contact_rate"] = self.rng.uniform([300, 30], [3000, 300]).tolist()

    def _hand(self, robot: dict[str, Any]) -> dict[str, Any]:
        """A hand that presses towards the object's centre."""
        grasp, rng = frame(robot["grasp"]), self.rng
        inward = -(grasp.rotation.T @ grasp.translation) + 1e-3
        if self.plane:  # a direction in the plane of the cell, which the grasp and the tip keep
            inward[PLANES[self.plane][2]] = 0.0
        surface = {"friction": float(rng.uniform(0.3, 1.2)), "half_width": rng.uniform(0.02, 0.08, 2).tolist()}
        if self.plane:
            surface["half_width"] = surface["half_width"][:1]
        direction, force = inward.tolist(), float(rng.uniform(50, 400))
        kind = rng.choice(["pad", "suction", "gripper", "box"])
        if kind == "pad":
            return {"pad": surface | {"normal": direction, "force": [float(rng.choice([0, 5])), force]}}
        if kind == "suction":
            cup = {"holding_force": force, "friction": surface["friction"], "radius": 0.05}
            return {"suction": cup | {"normal": direction}}
        if kind == "gripper":
            return {"gripper": surface | {"force": force, "axis": direction}}
        bound = rng.uniform(20, 200, len(self.components()))
        sides = {"lower": (-bound).tolist(), "upper": bound.tolist()}
        return {"box": sides | {"frame": str(rng.choice(["tip", "object"]))}}

    def _motors(self, torque: Any) -> dict[str, Any]:
        """Rotor inertia, friction, a curve and rates, in proportion to the torques."""
        rng, speed = self.rng, self.rng.uniform(1, 6)
        motors: dict[str, Any] = {"armature": rng.uniform(0, 0.3, len(torque)).tolist()}
        viscous = rng.uniform(0.01, 0.2) * torque / speed
        motors["friction"] = {"coulomb": (rng.uniform(0, 0.2) * torque).tolist(), "viscous": viscous.tolist()}
        if self.chance(0.4):
            curves = [[[0, most], [0.4 * speed, most], [1.5 * speed, 0.3 * most]] for most in torque.tolist()]
            motors["torque_speed"] = curves
        if self.chance(0.4):
            motors |= {"torque_rate": (rng.uniform(5, 30) * torque).tolist(), "jerk": float(rng.uniform(200, 2000))}
        return motors

    def _load(self) -> None:
        """What is carried, and what is uncertain of it."""
        rng = self.rng
        mass = float(rng.uniform(0.2, 6) if self.random else rng.uniform(1, 15))
        carried: dict[str, Any] = {"mass": mass, "inertia": random_inertia(rng, mass, 0.15).tolist()}
        if self.chance(0.15):
            carried["variation"] = {"mass": [float(rng.uniform(0.3, 1)), float(rng.uniform(1, 2))]}
            if self.chance(0.5):
                moment = float(rng.uniform(0.01, 0.1) * mass)
                carried["variation"] |= {f"m{self.plane[0] if self.plane else 'x'}": [-moment, moment]}
        if self.chance(0.3):
            carried["velocity"] = {"linear": float(rng.uniform(0.05, 1)), "angular": float(rng.uniform(0.2, 4))}
        self.cell["object"] = carried
        if self.chance(0.2):
            self.cell["gravity"] = (rng.uniform(0, 2) * np.array(self.cell["gravity"])).tolist()

    def _motion(self) -> dict[str, Any]:
        """A motion file: poses, waypoints, a table of poses or of joints, or standing still."""
        rng = self.rng
        size, turn = ((0.08, 0.2) if self.plane else (0.03, 0.1)) if self.random else (0.15, 0.2)
        far = rng.choice([0.3, 1, 1, 1, 2, 10], p=[0.2, 0.2, 0.2, 0.2, 0.15, 0.05])
        timing = {"duration": float(rng.uniform(0.2, 1.2)), "samples": int(rng.choice([11, 21, 31, 61, 101]))}
        timing["profile"] = str(rng.choice(PROFILES))
        end = self.start * self.moved(far * size, far * turn)
        kind = rng.choice(["poses", "waypoints", "table", "joints", "still"], p=[0.5, 0.15, 0.1, 0.2, 0.05])
        if kind == "poses":
            return timing | {"start": spatial_pose(self.start), "end": spatial_pose(end)}
        if kind == "waypoints":
            between = [self.start * pin.exp6(0.5 * pin.log6(self.start.actInv(end))) * self.moved(far * size / 3, 0.05)]
            return timing | {"waypoints": [spatial_pose(pose) for pose in (self.start, *between, end)]}
        return self._table(timing["duration"], timing["samples"], end, str(kind))

    def _table(self, duration: float, samples: int, end: Any, kind: str) -> dict[str, Any]:
        """A table along a screw from the start to the end, at rest at both; of standing still, both are the start."""
        share = np.linspace(0, 1, max(samples, 21))
        way = 0 * share if kind == "still" else share**3 * (10 - 15 * share + 6 * share**2)
        poses = [self.start * pin.exp6(float(part) * pin.log6(self.start.actInv(end))) for part in way]
        columns = {"t": duration * share}
        if kind != "joints":
            rows = np.array([pin.SE3ToXYZQUAT(pose) for pose in poses])
            columns |= dict(zip(QUATERNION_NAMES, rows.T, strict=True))
        else:
            for robot, model in zip(self.cell["robots"], self.models, strict=True):
                joints = self._followed(robot, model, poses)
                names = [f"q.{robot['name']}/{name}" for name in list(model.names)[1:]]
                columns |= dict(zip(names, joints.T, strict=True))
        self.table = columns
        return {"joints" if kind == "joints" else "file": "motion.csv"}

    def _followed(self, robot: dict[str, Any], model: Any, poses: list[Any]) -> Any:
        """Joints of an arm that holds the object along poses, by Newton steps; a path out of reach ends anywhere."""
        base, grasp, q, rows = frame(robot["base"]), frame(robot["grasp"]), np.array(robot["posture"]), []
        for pose in poses:
            for _ in range(8):
                reached, J = tip(model, robot, q)
                step = np.linalg.lstsq(J, pin.log6(reached.actInv(base.actInv(pose * grasp))).vector, rcond=1e-9)[0]
                q = q + np.clip(step, -0.3, 0.3)
            rows.append(q)
        return np.array(rows)

    def _mistake(self) -> None:
        """What people get wrong: a rule of a file that is broken, or a unit, a sign, an order."""
        broken = list(MISTAKES.values()) + [
            lambda cell, motion, one=one: one(cell, motion, 1) for _, one in HINTS.values()
        ]
        carried = self.cell["object"]
        carried["inertia"] = (carried["mass"] * np.array([0.02, 0.03, 0.04])).tolist()
        broken[self.rng.integers(len(broken))](self.cell, self.motion)

    def questions(self) -> dict[str, dict[str, Any]]:
        """What is asked, by kind: the function of mrts, and its arguments."""
        rng, arms = self.rng, len(self.models)
        shares = rng.dirichlet(np.full(arms, 2.0)).tolist()
        joints = sum(len(robot["posture"]) for robot in self.cell["robots"])
        asked = {
            "factor": {"call": "scale"},
            "factor, torque form": {"call": "scale", "formulation": "torque"},
            "factor, reserve": {"call": "scale", "distribute": "reserve"},
            "factor, shared": {"call": "scale", "shares": shares},
            "optimal": {"call": "retime"},
        }
        some: dict[str, dict[str, Any]] = {
            "factor, selected": {"call": "scale", "select": float(rng.uniform(0.05, 3))},
            "factor, even share": {"call": "scale", "shares": None},
            "factor, kept reserve": {"call": "scale", "reserve": 0.1},
            "factor, at samples": {"call": "scale", "between": None},
            "factor, weights": {"call": "scale", "weights": rng.uniform(0.2, 5, joints).tolist()},
            "factor, rates": {"call": "scale", "rates": float(rng.choice([5, 11.5, 50]))},
            "optimal, reserve": {"call": "retime", "distribute": "reserve"},
            "optimal, shared": {"call": "retime", "shares": shares},
            "optimal, moving": {"call": "retime", "start_speed": 0.3, "end_speed": 0.2},
        }
        if "variation" in self.cell["object"]:
            some = {
                "factor, possible load": {"call": "scale", "load": "possible"},
                "factor, nominal load": {"call": "scale", "load": "nominal"},
                "optimal, nominal load": {"call": "retime", "load": "nominal"},
            }
        kind = str(rng.choice(list(some)))
        asked[kind] = some[kind]
        if self.chance(0.2):
            rates = float(rng.choice([3, 11.5, 50]))
            asked["smooth, rates"] = {"call": "retime", "rates": rates, "distribute": "least-torque"}
        return asked

    def write(self, folder: Path) -> None:
        """All as files."""
        folder.mkdir(parents=True, exist_ok=True)
        texts = self.urdfs | {
            "cell.yaml": yaml.safe_dump(self.cell),
            "motion.yaml": yaml.safe_dump(self.motion),
            "questions.json": json.dumps(self.questions()),
        }
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        if self.table:
            write_table(folder / "motion.csv", self.table)


def write_cases(folder: Path, seed: int, numbers: range) -> None:
    """Write cases, each into a folder of its own."""
    for number in numbers:
        Draw(seed, number).write(folder / f"{number:05}")
