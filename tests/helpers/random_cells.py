"""Seeded random cells: planar ones with files on disk, and spatial arms as URDF text."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import yaml

PLANES = {"xy": (0, 1, 2, 1.0), "xz": (0, 2, 1, -1.0), "yz": (1, 2, 0, 1.0)}
"""Plane: its two axes, its normal axis, and the sign of first × second along that axis."""


WELL_CONDITIONED = 15


def rotation_in_plane(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def random_inertia(rng, mass, size):
    """Inertia of a random cloud of points: always that of a body; off-diagonal."""
    points = rng.normal(size=(8, 3)) * size
    return mass * sum(p @ p * np.eye(3) - np.outer(p, p) for p in points) / len(points)


def random_wrench_limits(rng, low, high, size):
    """Mostly limits on some components; sometimes none at all."""
    if rng.random() >= 0.6:
        return {}
    bounds = rng.uniform(low, high, size)
    lower = [None if rng.random() < 0.4 else -float(b) for b in bounds]
    return {"wrench": {"lower": lower, "upper": [None if rng.random() < 0.4 else float(b) for b in bounds]}}


def inertial_xml(rng, mass, size, rpy="0 0 0"):
    inertia = random_inertia(rng, mass, size)
    com = " ".join(map(str, rng.uniform(-size, size, 3)))
    keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    entries = " ".join(f'{key}="{inertia[place]:.17g}"' for key, place in keys.items())
    return f'<inertial><origin xyz="{com}" rpy="{rpy}"/><mass value="{mass:.17g}"/><inertia {entries}/></inertial>'


def random_planar_cell(rng, folder: Path, arms: int, samples: int = 11):
    """Write cell.yaml, arm URDFs and motion.yaml of a reachable planar cell; returns both paths."""
    plane = str(rng.choice(list(PLANES)))
    first, second, normal, handed = PLANES[plane]

    def lift(vector, out=0.0):
        full = np.zeros(3)
        full[[first, second]] = vector
        full[normal] = out
        return full.tolist()

    def turn(angle):
        # rpy is a rotation about one axis here, about +axis, while planar angles are about first × second
        rpy = np.zeros(3)
        rpy[normal] = handed * angle
        return rpy.tolist()

    start, start_angle = rng.uniform(-0.3, 0.3, 2), rng.uniform(-1, 1)
    robots = []
    for index in range(arms):
        lengths, angles = rng.uniform([0.5, 0.4, 0.05], [1.0, 0.9, 0.2]), rng.uniform(-np.pi, np.pi, 3)
        links = [rotation_in_plane(angle) @ [length, 0] for angle, length in zip(angles, lengths, strict=True)]
        signs = rng.choice([-1, 1], 3)
        q = np.array([rng.uniform(-2, 2), 0, rng.uniform(-2, 2)])
        # keep the elbow away from full stretch and full fold
        bend = rng.choice([-1, 1]) * rng.uniform(1.1, 2.0)
        q[1] = signs[1] * (bend - (angles[1] - angles[0]))
        absolute = np.cumsum(signs * q)
        tip = sum(rotation_in_plane(a) @ link for a, link in zip(absolute, links, strict=True))
        grasp, grasp_angle = rng.uniform(-0.4, 0.4, 2), rng.uniform(-1, 1)
        base_angle = start_angle + grasp_angle - absolute[2]
        base = start + rotation_in_plane(start_angle) @ grasp - rotation_in_plane(base_angle) @ tip
        urdf = folder / f"arm{index}.urdf"
        urdf.write_text(planar_urdf(rng, plane, links, signs * handed), encoding="utf-8")
        strength = rng.choice([0.6, 1.5, 5.0])
        robot = {
            "name": f"arm{index}",
            "urdf": urdf.name,
            "tip_link": "tip",
            "base": {"xyz": lift(base), "rpy": turn(base_angle)},
            "grasp": {"xyz": lift(grasp), "rpy": turn(grasp_angle)},
            "posture": (q + rng.uniform(-0.05, 0.05, 3)).tolist(),
            "torque": (strength * rng.uniform([40, 25, 6], [90, 50, 15])).tolist(),
        }
        robots.append(robot | random_wrench_limits(rng, 1, 40, 3))
    mass = rng.uniform(0.2, 6)
    cell = {
        "name": "random_cell",
        "gravity": lift(rng.normal(size=2) * 6),
        "plane": plane,
        "object": {"mass": mass, "inertia": random_inertia(rng, mass, 0.2).tolist()},
        "robots": robots,
    }
    motion = {
        "duration": float(rng.uniform(0.15, 1.2)),
        "samples": samples,
        "profile": str(rng.choice(["sinusoid", "trapezoid", "cubic", "quintic"])),
        "start": {"xyz": lift(start), "rpy": turn(start_angle)},
        "end": {"xyz": lift(start + rng.uniform(-0.06, 0.06, 2)), "rpy": turn(start_angle + rng.uniform(-0.15, 0.15))},
    }
    for name, data in (("cell.yaml", cell), ("motion.yaml", motion)):
        (folder / name).write_text(yaml.safe_dump(data), encoding="utf-8")
    return folder / "cell.yaml", folder / "motion.yaml"


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


def reachable_arm(rng, urdf: Path, joints: int):
    """Write a random arm; positions away from singularities, and the tip there. Some arms have none: draw another."""
    while True:
        urdf.write_text(random_spatial_urdf(rng, joints), encoding="utf-8")
        model = chain_model(urdf)
        data, frame = model.createData(), model.getFrameId("tip")
        for _ in range(50):
            q = rng.uniform(-2, 2, joints)
            pin.computeJointJacobians(model, data, configuration(model, q))
            pin.updateFramePlacements(model, data)
            J = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            if np.linalg.cond(J) < WELL_CONDITIONED:
                return q, data.oMf[frame].copy()


def random_spatial_cell(rng, folder: Path, arms: int, samples: int = 11, joints: int = 6):
    """Write cell.yaml, arm URDFs and motion.yaml of a reachable spatial cell; returns both paths."""
    start = pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.3, 0.3, 3))
    robots = []
    for index in range(arms):
        urdf = folder / f"arm{index}.urdf"
        q, T_base_tip = reachable_arm(rng, urdf, joints)
        grasp = pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.3, 0.3, 3))
        base = start * grasp * T_base_tip.inverse()
        strength = rng.choice([1.0, 2.5, 8.0])
        robot = {
            "name": f"arm{index}",
            "urdf": urdf.name,
            "tip_link": "tip",
            "base": {"xyz": base.translation.tolist(), "rpy": pin.rpy.matrixToRpy(base.rotation).tolist()},
            "grasp": {"xyz": grasp.translation.tolist(), "rpy": pin.rpy.matrixToRpy(grasp.rotation).tolist()},
            "posture": q.tolist(),
            "torque": (strength * rng.uniform(10, 40, joints)).tolist(),
        }
        robots.append(robot | random_wrench_limits(rng, 2, 60, 6))
    mass = rng.uniform(0.2, 6)
    cell = {
        "name": "random_cell",
        "gravity": (rng.normal(size=3) * 5).tolist(),
        "object": {"mass": mass, "inertia": random_inertia(rng, mass, 0.2).tolist()},
        "robots": robots,
    }
    turned = start.rotation @ pin.exp3(rng.uniform(-0.05, 0.05, 3))
    motion = {
        "duration": float(rng.uniform(0.1, 0.6)),
        "samples": samples,
        "profile": str(rng.choice(["sinusoid", "trapezoid", "cubic", "quintic"])),
        "start": {"xyz": start.translation.tolist(), "rpy": pin.rpy.matrixToRpy(start.rotation).tolist()},
        "end": {
            "xyz": (start.translation + rng.uniform(-0.012, 0.012, 3)).tolist(),
            "rpy": pin.rpy.matrixToRpy(turned).tolist(),
        },
    }
    for name, data in (("cell.yaml", cell), ("motion.yaml", motion)):
        (folder / name).write_text(yaml.safe_dump(data), encoding="utf-8")
    return folder / "cell.yaml", folder / "motion.yaml"
