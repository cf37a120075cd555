# SPDX-License-Identifier: MIT
"""A cell as the keys of a cell file: told, changed at paths, and written.

Paths lead to numbers of a cell and of a motion file, such as `robots.left.base.xyz[0]` and `motion.duration`.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from mrts.base.arrays import Array, without_infinity
from mrts.base.atomic_file import resolved_path, write_text_atomically
from mrts.base.errors import NEAREST_INERTIA, InputError, as_path, check_type, did_you_mean, is_number, joined
from mrts.base.formats.record import Pose, Record, checked, dumped
from mrts.base.input_file import FileKind, FileReference, is_uri, named_in, plain
from mrts.base.load_box import UNITS
from mrts.base.rigid_transform import RigidTransform, rpy_from_rotation
from mrts.base.yaml_text import parse_yaml, yaml_text
from mrts.cell.cell import Cell
from mrts.cell.cell_file import OF_ARM, POSES, CellDescription, ObjectDescription, RobotDescription, robot_values
from mrts.cell.generation import described_model
from mrts.cell.points import LinkPointLimit, ObjectRates, rate_limits
from mrts.cell.record import BodyShape, CellManifest, CellRecord
from mrts.cell.robot import PER_JOINT, RATINGS, Robot

SAME_ROTATION = 1e-12
"""Largest difference of an entry of a rotation that comes back from its angles: rounding, or a matrix of other make."""

FILES: dict[Any, FileKind] = {"urdf": "URDF", "mesh": "mesh", "joint_limits": "joint limits file"}
"""Keys that say where a file is, which need not be alike: its hash is compared, or what was taken from it."""

Keys = tuple[str | int, ...]
"""Where a number stands, from "cell" or "motion" inward."""

ONE_FOR_ALL = frozenset(PER_JOINT)
"""Keys of `motors` where one number stands for all joints."""

NOTHING_THERE = "the file says nothing of {}, and there is no default. Write it there first."

NEED_NOT_BE_GIVEN = frozenset({"linear", "angular", "speed", "acceleration", "friction", "height", *RATINGS})
"""Keys where null stands for a number that is not limited or not known; so it does in lists of limits."""

BY_UNIT = {
    "m": ("xyz", "half_width", "height", "point", "at", "radius", "length", "box"),
    "rad": ("rpy",),
    "s": ("duration",),
    "m/s": ("linear", "speed"),
    "rad/s": ("angular",),
    "m/s²": ("gravity",),
    "kg": ("mass",),
    "kg m²": ("inertia",),
    "N": ("force", "holding_force"),
    "W": ("power",),
}
BY_KEY = {key: unit for unit, keys in BY_UNIT.items() for key in keys}

BY_UNITS_OF_JOINT = {
    ("rad", "m"): ("posture",),
    ("rad/s", "m/s"): ("velocity",),
    ("rad/s²", "m/s²"): ("acceleration",),
    ("rad/s³", "m/s³"): ("jerk",),
    ("N m", "N"): ("torque", "coulomb", "rated"),
    ("N m/s", "N/s"): ("torque_rate",),
    ("N m s/rad", "N s/m"): ("viscous",),
    ("kg m²", "kg"): ("armature",),
    ("W", "W"): ("power",),
}
OF_JOINT = {key: units for units, keys in BY_UNITS_OF_JOINT.items() for key in keys}
"""Units of what a joint has: of a revolute one, and of a prismatic one."""

OF_CURVE = ("rad/s", "N m"), ("m/s", "N")


def cell_keys(cell: Cell) -> dict[str, Any]:
    """Keys and values of a cell file that say what the cell is now; None where there is no limit, or nothing is said.

    Files stand as its own cell file names them; a contact that no cell file can hold is None.
    """
    box = cell.load_box
    moments = cell.load[4:].tolist()
    rates = {key: without_infinity(getattr(cell, f"object_{key}_limit")) for key in ("velocity", "acceleration")}
    variation: dict[str, Any] = {} if box is None else {name: list(ends) for name, ends in box.ranges.items()}
    return {
        "name": cell.name,
        "gravity": cell.gravity.tolist(),
        "plane": cell.plane,
        "power": cell.power_limit,
        "inertia": "lenient" if any(remark.code == NEAREST_INERTIA for remark in cell.remarks) else None,
        "object": {
            "mass": cell.mass,
            "inertia": cell.inertia.tolist() if any(moments[3:]) else moments[:3],
            "shape": None if cell.object_shape is None else _shape_keys(cell.object_shape),
            "variation": variation or None,
            **{key: {"linear": linear, "angular": angular} for key, (linear, angular) in rates.items()},
            "frames": dumped(cell.object_points) or None,
            "carries": dumped(cell.carried) or None,
        },
        "surroundings": [_shape_keys(one) for one in cell.surroundings] or None,
        "robots": [_robot(robot) for robot in cell.robots],
    }


def pose_keys(T: RigidTransform) -> dict[str, list[float]]:
    """The keys of a pose: `xyz` [m] and `rpy` [rad]."""
    return {"xyz": T.p.tolist(), "rpy": rpy_from_rotation(T.R)}


def _shape_keys(shape: BodyShape) -> dict[str, Any]:
    return shape.model_dump() | ({"pose": None} if shape.pose.model_dump() == Pose().model_dump() else {})


def _sides(lower: Array, upper: Array) -> dict[str, list[float | None]] | list[float | None]:
    sides = {"lower": without_infinity(lower), "upper": without_infinity(upper)}
    return sides["upper"] if np.array_equal(lower, -upper) else sides


def _robot(robot: Robot) -> dict[str, Any]:
    source, motors = robot.source, robot.motors
    points = [{key: getattr(one, key) for key in LinkPointLimit.model_fields} for one in robot.point_limits]
    per_joint = {name: without_infinity(getattr(motors, name)) for name in ("armature", *RATINGS)}
    return {
        "name": robot.name,
        "urdf": source.urdf,
        "base_link": source.base_link,
        "tip_link": source.tip_link,
        **{key: pose_keys(getattr(robot, name)) for key, name in POSES.items()},
        "posture": robot.posture.tolist(),
        "torque": _sides(robot.torque_lower, robot.torque_upper),
        "velocity": without_infinity(robot.velocity_limit),
        "acceleration": _sides(robot.acceleration_lower, robot.acceleration_upper),
        "frames": points or None,
        "wrench": {"lower": without_infinity(robot.wrench_lower), "upper": without_infinity(robot.wrench_upper)},
        "contact_rate": without_infinity(robot.contact_rate[[0, -1]]),
        "contact": [contact.given for contact in robot.contacts],
        "fixed": source.fixed or None,
        "motors": per_joint
        | {
            "friction": {"coulomb": motors.coulomb.tolist(), "viscous": motors.viscous.tolist()},
            "torque_speed": [None if curve is None else curve.tolist() for curve in motors.torque_speed],
        },
    }


def with_values(cell: Cell, values: Mapping[str, Any]) -> Cell:
    """See `mrts.Cell.with_values`."""
    check_type("values", values, Mapping)
    keys = cell_keys(cell)
    places = _places(keys, values)
    for path, place in places.items():
        value = values[path]
        set_value(keys, place, value if isinstance(value, RigidTransform) else plain(path, value))
    changes: dict[str, Any] = {}
    of_robots: dict[int, dict[str, Any]] = {}
    for path, place in places.items():
        match place:
            case ("gravity", *_):
                changes["gravity"] = np.array(_given("cell", "gravity", CellDescription, keys["gravity"]))
            case ("object", "mass"):
                mass: float = _given("cell", "object.mass", ObjectDescription, keys["object"]["mass"])
                changes["load"] = np.array([mass, *cell.load[1:]])
                changes["load_box"] = None if cell.load_box is None else replace(cell.load_box, mass=mass)
            case ("object", "velocity" | "acceleration" as key, *_):
                rates: ObjectRates = _given("cell", f"object.{key}", ObjectDescription, keys["object"][key] or {})
                changes[f"object_{key}_limit"] = rate_limits(rates)
            case ("robots", int(at), str(key), *_) if key in OF_ARM:
                robot, given = cell.robots[at], keys["robots"][at][key]
                where = f"robot '{robot.name}'"
                if not isinstance(given, RigidTransform):
                    given = _given(where, key, RobotDescription, {} if given is None else given)
                read = of_robots.setdefault(at, {})
                read |= robot_values(where, key, given, vars(robot) | read, cell.wrench_components)
                if all(other[3:4] == ("xyz",) for other in places.values() if other[:3] == place[:3]):
                    R = getattr(robot, POSES[key]).R  # as it is, not as its angles give it
                    read[POSES[key]] = RigidTransform(R, read[POSES[key]].p)
            case _:
                rule = "is not changed in Python: change the cell file, and read it again."
                raise InputError("values", rule, key=path)
    robots = [replace(robot, **of_robots[at]) if at in of_robots else robot for at, robot in enumerate(cell.robots)]
    return replace(cell, robots=tuple(robots), **changes)


def _places(keys: dict[str, Any], paths: Iterable[str]) -> dict[str, Keys]:
    """Where paths lead, none into what another changes."""
    places: dict[str, Keys] = {}
    for path in paths:
        check_type("values: path", path, str)
        try:
            place = find_keys({"cell": keys}, path)[1:]
        except InputError as error:
            raise error.inside("values", path) from None
        for other, taken in places.items():
            if place[: len(taken)] == taken or taken[: len(place)] == place:
                raise InputError("values", f"is changed by '{other}' too: say each number once.", key=path)
        places[path] = place
    return places


def _given(where: str, key: str, description: type[Record], value: object) -> Any:
    try:
        return checked(description.model_fields[key.rpartition(".")[2]], value)
    except InputError as error:
        raise error.inside(where, key) from None


def cell_text(cell: Cell, path: Path | str | None) -> str:
    """See `mrts.Cell.to_yaml`."""
    target = None if path is None else resolved_path(as_path("path", path))
    where = Path(f"cell '{cell.name}'")
    for key, rule in _NOT_IN_FILES.items():
        if getattr(cell, key) != getattr(Cell, key):
            raise InputError(where, rule, key=key)
    if cell.folder is None:
        rule = (
            "it is not known where its URDFs are, because it was read from generated files or a saved result. Read its "
            "cell file: mrts.load_cell(path)."
        )
        raise InputError(where, rule, key="folder")
    beside = None if target is None else target.parent
    text = yaml_text(_written(cell, cell.folder, beside))
    given = parse_yaml(text)
    model = described_model(given, beside or cell.folder, str(where))
    _check_same(where, cell, model.record)
    if target is not None:
        files = (reference.path(where, target.parent) for reference in named_files(given).values())
        if any(file.resolve() == target for file in files):
            raise InputError(target, "is a file that the cell names, its URDF or mesh. Choose another name.")
        write_text_atomically(target, text)
    return text


_NOT_IN_FILES = {
    "reserve": "a cell file holds no reserve: write cell.with_reserve(0), and give the reserve to what is asked of it.",
    "limits": "a cell file holds no functions: write cell.with_limits(), and give them to the cell that is read.",
    "enforces_velocity_limits": "a cell file cannot leave velocity limits out: write the cell before "
    "without_velocity_limits().",
}


def _written(cell: Cell, folder: Path, beside: Path | None) -> dict[str, Any]:
    """The keys of a cell file in another folder, without what its URDFs say anyway."""
    keys = cell_keys(cell)
    for place, named in named_files(keys).items():
        if not is_uri(named.text):
            file = (folder / named.text).resolve()
            set_value(keys, place, file.as_posix() if beside is None else named_in(beside, file))
    for robot, said in zip(cell.robots, keys["robots"], strict=True):
        motors = said["motors"]
        if robot.source.effort is not None:
            del said["torque"]
        if robot.source.velocity is not None:
            del said["velocity"]
        if robot.source.friction is not None:
            del motors["friction"]
        elif not robot.motors.has_friction:
            motors["friction"] = "none"
        if not np.any(robot.motors.armature):
            del motors["armature"]
    written: dict[str, Any] = _known(keys)
    return written


def _known(value: Any) -> Any:
    """A value of YAML without keys that say nothing: nulls, lists of them, and mappings without any other key.

    A list of nulls says something of velocities: that there are no limits, whatever the URDF has.
    """
    if isinstance(value, list):
        return None if all(each is None for each in value) else [_known(each) for each in value]
    if not isinstance(value, Mapping):
        return value
    said = {key: each if key == "velocity" and isinstance(each, list) else _known(each) for key, each in value.items()}
    return {key: each for key, each in said.items() if each is not None} or None


def manifest_of(cell: Cell) -> CellManifest:
    """The manifest of a cell as it is now."""
    return cell.generated.manifest.model_copy(update={"cell": CellRecord(**cell.record())})


def differences(one: CellRecord, other: CellRecord) -> Iterator[tuple[str, Any, Any]]:
    """Key and both values of all that differs between two cells, but for rounding of rotations."""
    numbers, found = (
        dict(leaves(dumped(cell.record() | {"remarks": (), "surfaces": [*cell.surfaces.values()]})))
        for cell in (one, other)
    )
    for keys in dict.fromkeys([*numbers, *found]):
        first: Any = numbers.get(keys)
        second: Any = found.get(keys)
        same = first == second or (keys[-3:-2] == ("R",) and abs(first - second) <= SAME_ROTATION)
        if not same and FILES.keys().isdisjoint(keys):
            yield keys_text(keys), first, second


def _check_same(where: Path, ours: CellRecord, read: CellRecord) -> None:
    """Refuse what a cell file cannot hold: what it reads back to is another cell."""
    for key, value, other in differences(ours, read):
        if key.endswith("sha256"):
            raise InputError(where, "this file is another one than the cell was made from.", key=key)
        rule = (
            f"a cell file cannot hold this value, it would be read as {json.dumps(other)}: it is another one's to say "
            "(the URDF's), or one value for several."
        )
        raise InputError(where, rule, key=key, value=value)


def leaves(value: Any, keys: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """The keys that lead to each number and text of a value of JSON, and what stands there."""
    if not isinstance(value, dict | list):
        yield keys, value
        return
    for key, inside in value.items() if isinstance(value, dict) else enumerate(value):
        yield from leaves(inside, (*keys, key))


def keys_text(keys: Keys) -> str:
    """Keys as a path, such as `robots[0].base.xyz[1]`."""
    return reduce(joined, (f"[{key}]" if isinstance(key, int) else key for key in keys), "")


def named_files(keys: Mapping[str, Any]) -> dict[Keys, FileReference]:
    """What the keys of a cell file say of all files that they name, by the keys on the way there."""
    return {
        place: FileReference(text, keys_text(place), FILES[place[-1]])
        for place, text in leaves(keys)
        if place[-1] in FILES and isinstance(text, str)
    }


def find_keys(files: Mapping[str, Any], path: str) -> Keys:
    """Where a path leads.

    Args:
        files: Keys and values of the "cell" and, if there is one, the "motion" file, what they leave out filled in.
            Where one number stands for all joints and the path names a joint, it becomes a list here.
        path: As a user writes it; `robots.left` and `robots[0]` are the same, and so are `duration` and
            `motion.duration`.

    Raises:
        InputError: If it leads to no number.
    """
    top = re.split(r"[.\[]", path)[0]
    of_motion = top == "motion" or (top in files.get("motion", {}) and top not in files["cell"])
    keys: Keys = ("motion" if of_motion else "cell",)
    rest = path[len(top) :] if top == "motion" else f".{path}"
    if keys[0] not in files:
        raise InputError("", "is of a motion: paths of a cell begin in its file.")
    if keys == ("motion",) and not files["motion"]:
        raise InputError("", "the motion is a table, of which no number varies. Give it by poses to vary it.")
    here = value_at(files, keys)
    while rest:
        if rest.startswith("[") and is_number(here) and "motors" in keys and keys[-1] in ONE_FOR_ALL:
            here = [here] * len(value_at(files, keys[:3])["posture"])
            set_value(files, keys, here)
        key, rest = _step(here, keys, rest, files)
        keys, here = (*keys, key), here[key]
    if here is None and not isinstance(keys[-1], int) and keys[-1] not in NEED_NOT_BE_GIVEN:
        raise InputError("", NOTHING_THERE.format(path_text(files, keys)))
    return keys


def path_text(files: Mapping[str, Any], keys: Keys) -> str:
    """The path to a place as results name it: robots by name, numbers of the motion file after `motion`."""
    inside = keys[1:] if keys[0] == "cell" else keys
    match keys:
        case "cell", "robots", int(at), *_:
            inside = ("robots", files["cell"]["robots"][at]["name"], *keys[3:])
    return keys_text(inside)


def value_at(files: Mapping[str, Any], keys: Keys) -> Any:
    """What stands at a place."""
    here: Any = files
    for key in keys:
        here = here[key]
    return here


def numbers_below(files: Mapping[str, Any], keys: Keys) -> Iterator[Keys]:
    """The places of all numbers at a place and inside of it."""
    return (place for place, value in leaves(value_at(files, keys), keys) if is_number(value))


def number_unit(keys: Keys, cell: Cell) -> str:
    """Unit of the number at a place; empty if it has none, or its file does not say."""
    words = [key for key in keys if isinstance(key, str)]
    if "variation" in words:
        return UNITS.get(words[words.index("variation") + 1], "")
    if "fixed" in words:
        return ""
    match keys:
        case "cell", "robots", int(at), *_:
            if unit := _robot_unit(keys, cell.robots[at], cell.wrench_units):
                return unit
    if "acceleration" in words:
        return f"{BY_KEY.get(words[-1], 'm/s')}²"
    return next((BY_KEY[word] for word in words if word in BY_KEY), "")


def _robot_unit(keys: Keys, robot: Robot, wrench_units: Sequence[str]) -> str:
    """Unit of what a joint or a component of the wrench has; empty of all else."""
    index, sliding = keys[-1] if isinstance(keys[-1], int) else 0, [kind == "prismatic" for kind in robot.joint_types]
    if "wrench" in keys or "box" in keys:
        return wrench_units[index]
    if "contact_rate" in keys:
        return ("N/s", "N m/s")[index]
    if "torque_speed" in keys:
        return OF_CURVE[sliding[keys[-3] if isinstance(keys[-3], int) else 0]][index]
    of_joint = next((OF_JOINT[key] for key in keys if key in OF_JOINT and "frames" not in keys), None)
    return of_joint[sliding[index]] if of_joint else ""


def with_place(file: dict[str, Any], filled: Mapping[str, Any], keys: Keys) -> None:
    """Write into a file what it leaves out on the way to a place, so that the place is there."""
    here: Any = file
    full: Any = filled
    for key in keys[:-1]:
        full = full[key]
        there = here.get(key) if isinstance(here, dict) else here[key]
        if not isinstance(there, dict | list) or (isinstance(there, list) and len(there) != len(full)):
            here[key] = deepcopy(full)
        here = here[key]


def set_value(file: Mapping[str, Any], keys: Keys, value: Any) -> None:
    """Write a value at a place, from the file's own keys inward."""
    value_at(file, keys[:-1])[keys[-1]] = value


def _step(here: Any, keys: Keys, rest: str, files: Mapping[str, Any]) -> tuple[str | int, str]:
    """The key that a path goes on with, and what is left of it."""
    where = path_text(files, keys) or "the cell file"
    if here is None:
        raise InputError("", NOTHING_THERE.format(where))
    if not isinstance(here, dict | list):
        raise InputError("", f"{where} is {here!r}; nothing stands inside of it.")
    if not here:
        raise InputError("", f"{where} is empty.")
    places: dict[str, str | int] = {}
    if isinstance(here, list):
        places = {f"[{at}]": at for at in range(len(here))}
        names = {each["name"]: at for at, each in enumerate(here) if isinstance(each, dict) and "name" in each}
    else:
        names = {key: key for key in here}
    places |= {f".{name}": key for name, key in names.items()}
    ends = ("", ".", "[")
    fitting = [at for at in places if rest.startswith(at) and (at[-1] == "]" or rest[len(at) : len(at) + 1] in ends)]
    if fitting:
        place = max(fitting, key=len)  # names may hold dots
        return places[place], rest[len(place) :]
    if isinstance(here, list) and (not names or rest.startswith("[")):
        raise InputError("", f"{where} has {len(here)} values: {where}[0] to {where}[{len(here) - 1}].")
    wrong = re.split(r"(?!^)[.\[]", rest.removeprefix("."))[0]
    raise InputError("", f"there is no '{wrong}' in {where}{did_you_mean(wrong, names)} There are {', '.join(names)}.")
