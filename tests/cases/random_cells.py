"""Random structures of cells: arms as URDF text, where they stand, how they hold; planar and spatial."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pinocchio as pin
import yaml
from shipped_cells import cell_of_arms

PLANES = {"xy": (0, 1, 2, 1.0), "xz": (0, 2, 1, -1.0), "yz": (1, 2, 0, 1.0)}
"""Plane: its two axes, its normal axis, and the sign of first × second along that axis."""

WELL_CONDITIONED = 15


@dataclass
class Structure:
    """What the generated C of a cell depends on: its file without limits and object, and texts of URDFs by file name.

    Postures reach the start, a pose of the object: (position, angle) in the plane, or SE3.
    """

    description: dict[str, Any]
    urdfs: dict[str, str]
    start: Any


def rotation_in_plane(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def random_inertia(rng, mass, size):
    """Inertia of a random cloud of points: always that of a body; off-diagonal."""
    points = rng.normal(size=(8, 3)) * size
    return mass * sum(p @ p * np.eye(3) - np.outer(p, p) for p in points) / len(points)


def inertial_xml(rng, mass, size, rpy="0 0 0"):
    inertia = random_inertia(rng, mass, size)
    com = " ".join(map(str, rng.uniform(-size, size, 3)))
    keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    entries = " ".join(f'{key}="{inertia[place]:.17g}"' for key, place in keys.items())
    return f'<inertial><origin xyz="{com}" rpy="{rpy}"/><mass value="{mass:.17g}"/><inertia {entries}/></inertial>'


def arm_keys(index, base, grasp, posture):
    """Keys of a robot of a cell file."""
    name = f"arm{index}"
    keys = {"name": name, "urdf": f"{name}.urdf", "tip_link": "tip"}
    return keys | {"base": base, "grasp": grasp, "posture": posture}


def planar_structure(rng, plane: str, arms: int) -> Structure:
    """A reachable planar cell, whose elbows are away from full stretch and full fold."""
    *_, handed = PLANES[plane]
    start, start_angle = rng.uniform(-0.3, 0.3, 2), rng.uniform(-1, 1)
    robots, urdfs = [], {}
    for index in range(arms):
        lengths, angles = rng.uniform([0.5, 0.4, 0.05], [1.0, 0.9, 0.2]), rng.uniform(-np.pi, np.pi, 3)
        links = [rotation_in_plane(angle) @ [length, 0] for angle, length in zip(angles, lengths, strict=True)]
        signs = rng.choice([-1, 1], 3)
        q = np.array([rng.uniform(-2, 2), 0, rng.uniform(-2, 2)])
        bend = rng.choice([-1, 1]) * rng.uniform(1.1, 2.0)
        q[1] = signs[1] * (bend - (angles[1] - angles[0]))
        absolute = np.cumsum(signs * q)
        tip = sum(rotation_in_plane(a) @ link for a, link in zip(absolute, links, strict=True))
        grasp, grasp_angle = rng.uniform(-0.4, 0.4, 2), rng.uniform(-1, 1)
        base_angle = start_angle + grasp_angle - absolute[2]
        base = start + rotation_in_plane(start_angle) @ grasp - rotation_in_plane(base_angle) @ tip
        urdfs[f"arm{index}.urdf"] = planar_urdf(rng, plane, links, signs * handed)
        poses = planar_pose(plane, base, base_angle), planar_pose(plane, grasp, grasp_angle)
        robots.append(arm_keys(index, *poses, q.tolist()))
    gravity = planar_pose(plane, rng.normal(size=2) * 6, 0)["xyz"]
    return Structure({"gravity": gravity, "plane": plane, "robots": robots}, urdfs, (start, start_angle))


def planar_pose(plane: str, position, angle: float):
    """A pose of a cell file; planar angles are about first × second, rpy is about +axis."""
    first, second, normal, handed = PLANES[plane]
    xyz, rpy = np.zeros(3), np.zeros(3)
    xyz[[first, second]] = position
    rpy[normal] = handed * angle
    return {"xyz": xyz.tolist(), "rpy": rpy.tolist()}


def planar_urdf(rng, plane, links, signs):
    first, second, normal, _ = PLANES[plane]
    parts = ['<robot name="arm"><link name="base"/>']
    parent, origin = "base", np.zeros(3)
    for index, (link, sign) in enumerate(zip(links, signs, strict=True)):
        axis = np.zeros(3)
        axis[normal] = sign
        mass = rng.uniform(0.5, 5)
        parts.append(f'<link name="l{index}">{inertial_xml(rng, mass, 0.3 * np.hypot(*link))}</link>')
        parts.append(joint_xml(f"j{index}", "continuous", parent, f"l{index}", origin, axis=axis))
        parent, origin = f"l{index}", np.zeros(3)
        origin[[first, second]] = link
    parts.append('<link name="tip"/>')
    parts.append(joint_xml("grip", "fixed", parent, "tip", origin))
    return "\n".join([*parts, "</robot>"])


def joint_xml(name, kind, parent, child, xyz, rpy=(0, 0, 0), axis=(1, 0, 0)):
    limit = "" if kind == "fixed" else '<limit lower="-3" upper="3" velocity="1" effort="10"/>'
    place = f'<origin xyz="{" ".join(map(str, xyz))}" rpy="{" ".join(map(str, rpy))}"/>'
    direction = f'<axis xyz="{" ".join(map(str, axis))}"/>' if kind != "fixed" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"{place}{direction}{limit}</joint>"
    )


def random_spatial_urdf(rng, joints: int):
    """A chain with turned frames, fixed links, a side branch with a moving joint, and a sliding joint."""
    parts = ['<robot name="arm"><link name="base">', inertial_xml(rng, 2.0, 0.1), "</link>"]
    parent = "base"

    def frame():
        return rng.uniform(-0.3, 0.3, 3), rng.uniform(-3, 3, 3)

    for index in range(joints):
        name = f"l{index}"
        turned = " ".join(map(str, rng.uniform(-3, 3, 3)))
        parts.append(f'<link name="{name}">{inertial_xml(rng, rng.uniform(0.3, 4), 0.1, turned)}</link>')
        kind = "prismatic" if index == 2 else ("continuous" if index % 2 else "revolute")
        parts.append(joint_xml(f"j{index}", kind, parent, name, *frame(), axis=rng.normal(size=3)))
        if index == 1:
            for side, side_kind in (("finger", "revolute"), ("camera", "fixed")):
                parts.append(f'<link name="{side}">{inertial_xml(rng, 0.5, 0.05)}</link>')
                parts.append(joint_xml(f"to_{side}", side_kind, name, side, *frame(), axis=rng.normal(size=3)))
        if index == 3:
            parts.append(f'<link name="flange">{inertial_xml(rng, 0.7, 0.05)}</link>')
            parts.append(joint_xml("to_flange", "fixed", name, "flange", *frame()))
            name = "flange"
        parent = name
    parts.append('<link name="tip"/>')
    parts.append(joint_xml("grip", "fixed", parent, "tip", *frame()))
    return "\n".join([*parts, "</robot>"])


def configuration(model, q):
    """Pinocchio's configuration vector: a continuous joint is (cos, sin)."""
    entries = []
    for joint, value in zip(model.joints[1:], q, strict=True):
        entries += [np.cos(value), np.sin(value)] if joint.nq == 2 else [value]
    return np.array(entries)


def chain_model(path: Path, tip: str = "tip"):
    """Pinocchio's model of the chain to a tip: every other joint is locked at zero."""
    full = pin.buildModelFromUrdf(str(path))
    supports = set(full.supports[full.frames[full.getFrameId(tip)].parentJoint])
    lock = [joint for joint in range(1, full.njoints) if joint not in supports]
    return pin.buildReducedModel(full, lock, pin.neutral(full)) if lock else full


def reachable_arm(rng, folder: Path, joints: int):
    """URDF text of a random arm; positions away from singularities, and the tip there. Some have none: draw another."""
    while True:
        text = random_spatial_urdf(rng, joints)
        (folder / "arm.urdf").write_text(text, encoding="utf-8")
        model = chain_model(folder / "arm.urdf")
        data, frame = model.createData(), model.getFrameId("tip")
        for _ in range(50):
            q = rng.uniform(-2, 2, joints)
            pin.computeJointJacobians(model, data, configuration(model, q))
            pin.updateFramePlacements(model, data)
            J = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            if np.linalg.cond(J) < WELL_CONDITIONED:
                return text, q, data.oMf[frame].copy()


def spatial_structure(rng, arms: int, joints: int = 6) -> Structure:
    """A reachable spatial cell."""
    start = pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.3, 0.3, 3))
    robots, urdfs = [], {}
    for index in range(arms):
        with TemporaryDirectory() as folder:
            urdfs[f"arm{index}.urdf"], q, T_base_tip = reachable_arm(rng, Path(folder), joints)
        grasp = pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.3, 0.3, 3))
        base = spatial_pose(start * grasp * T_base_tip.inverse())
        robots.append(arm_keys(index, base, spatial_pose(grasp), q.tolist()))
    return Structure({"gravity": (rng.normal(size=3) * 5).tolist(), "robots": robots}, urdfs, start)


def spatial_pose(T):
    """A pose of a cell file."""
    return {"xyz": T.translation.tolist(), "rpy": pin.rpy.matrixToRpy(T.rotation).tolist()}


def spatial_cell(folder, seed, joints=(6, 7, 6)):
    rng = np.random.default_rng(seed)
    robots = []
    for index, count in enumerate(joints):
        (folder / f"arm{index}.urdf").write_text(random_spatial_urdf(rng, count), encoding="utf-8")
        poses = ({"xyz": rng.uniform(-far, far, 3).tolist(), "rpy": rng.uniform(-3, 3, 3).tolist()} for far in (1, 0.5))
        robots.append(arm_keys(index, *poses, [0.0] * count))
    inertia = [[0.05, 0.01, -0.01], [0.01, 0.06, 0.02], [-0.01, 0.02, 0.07]]
    path = cell_of_arms(folder, *robots, gravity=[1.0, -2.0, -9.5], mass=2.0, inertia=inertia)
    return path, yaml.safe_load(path.read_text(encoding="utf-8"))
