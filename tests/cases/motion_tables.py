"""Tables of motions as a user's tools write them: few digits, columns left out, hands a little off."""

from dataclasses import replace

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

import mrts

QUATERNION_NAMES = ["px", "py", "pz", "qx", "qy", "qz", "qw"]
RATE_NAMES = ["vx", "vy", "vz", "wx", "wy", "wz", "ax", "ay", "az", "alphax", "alphay", "alphaz"]
START, LIFTED, TURNED = {"xyz": [0, 0.1, 0.35]}, {"xyz": [0, 0.1, 0.5]}, {"xyz": [0.03, 0.2, 0.5], "rpy": [0.2, 0, 0.3]}


def moved(end, samples=101, profile="quintic"):
    poses = [{"rpy": [0, 0, 0]} | pose for pose in (START, end)]
    keys = {"duration": 0.8, "samples": samples, "profile": profile, "start": poses[0], "end": poses[1]}
    return mrts.load_motion(keys)


def exact_motions(cell):
    """Joints that carry the object exactly, and their c²⁺, by end and number of rows."""
    found = {}
    for name, end in (("lift", LIFTED), ("turn", TURNED)):
        for samples in (11, 101):
            followed = mrts.follow_object(cell, moved(end, samples))
            found[name, samples] = followed, mrts.scale(cell, followed, between=None).range.upper.c2
    return found


def columns_of(cell, followed, kept=("q", "dq", "ddq")):
    names = [f"{robot.name}/{joint}" for robot in cell.robots for joint in robot.joints]
    columns = {"t": followed.object.time}
    for part in kept:
        columns |= dict(zip([f"{part}.{name}" for name in names], getattr(followed, part).T, strict=True))
    return columns


def object_columns(motion, *, rates):
    values = [motion.position, Rotation.from_matrix(motion.rotation).as_quat()]
    names = QUATERNION_NAMES + (RATE_NAMES if rates else [])
    if rates:
        values += [motion.twist, motion.acceleration]
    return {"t": motion.time} | dict(zip(names, np.concatenate(values, axis=1).T, strict=True))


def table_text(columns, form=".12g"):
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *(",".join(format(value, form) for value in row) for row in rows)]) + "\n"


def write_table(path, columns, form=".12g"):
    path.write_text(table_text(columns, form))
    return path


def read(cell, path):
    return mrts.scale(cell, mrts.load_motion(path), between=None)  # at its rows


def codes(motion):
    return [remark.code for remark in motion.remarks]


def perturbed(followed, size, turns=2):
    """Joints off the exact ones by smooth waves, with their own derivatives; sizes in rad."""
    rng = np.random.default_rng(11)
    time = followed.object.time
    rate = 2 * np.pi * turns / time[-1]
    shift = rng.uniform(0, 2 * np.pi, followed.q.shape[1])
    amplitude = size * rng.uniform(0.5, 1, followed.q.shape[1])
    angle = rate * time[:, None] + shift
    return replace(
        followed,
        q=followed.q + amplitude * np.sin(angle),
        dq=followed.dq + amplitude * rate * np.cos(angle),
        ddq=followed.ddq - amplitude * rate**2 * np.sin(angle),
    )


def scaled(columns, prefix, factor):
    return {name: values * (factor if name.startswith(prefix) else 1) for name, values in columns.items()}


def object_table(motion, *, rates):
    columns = object_columns(motion, rates=rates)
    return table_text(columns | {"t": columns["t"] + 3.0})  # a table may start at any time


def joint_table(cell, followed, parts=("q", "dq", "ddq")):
    return table_text(columns_of(cell, followed, parts))


def write_motion(folder, **keys):
    (folder / "motion.yaml").write_text(yaml.safe_dump(keys), encoding="utf-8")
    return folder / "motion.yaml"
