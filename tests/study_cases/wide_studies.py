"""Studies that vary every number that native calls take."""

import yaml

import mrts


def wide_study(folder, cell, motion, *, spread, count, seed=1, limits=0.2, mass=(0.7, 1.3), inertia=1e-3):
    """Read a study that varies every number that native calls take: poses, gravity, object, postures, limits, motion.

    Poses and postures go by `spread` [m, rad] each way, limits and moments by shares (those of a thin body soon break a
    rule), the mass by a factor within `mass`.
    """
    given, path = yaml.safe_load(cell.read_text()), yaml.safe_load(motion.read_text())
    axes = ["xyz".index(axis) for axis in given.get("plane") or "xyz"]
    around = axes if len(axes) > 2 else sorted({0, 1, 2} - set(axes))
    parts = [("xyz", axis) for axis in axes] + [("rpy", axis) for axis in around]

    def pose(name, of):
        return [(f"{name}.{part}[{axis}]", (of or {}).get(part, [0, 0, 0])[axis], spread) for part, axis in parts]

    planar = "plane" in given
    numbers = [each for robot in given["robots"] for each in _of_robot(robot, pose, spread, limits, planar=planar)]
    numbers += [(f"gravity[{axis}]", given["gravity"][axis], 0.3) for axis in axes]
    numbers += [number for end in ("start", "end") for number in pose(f"motion.{end}", path[end])]
    numbers.append(("motion.duration", path["duration"], 0.1 * path["duration"]))
    moments = given["object"]["inertia"]
    if not isinstance(moments[0], list):
        numbers += [(f"object.inertia[{axis}]", value, inertia * value) for axis, value in enumerate(moments)]
    vary = {name: {"from": value - width, "to": value + width} for name, value, width in numbers}
    vary["object.mass"] = {"from": mass[0] * given["object"]["mass"], "to": mass[1] * given["object"]["mass"]}
    file = folder / "study.yaml"
    named = {"cell": str(cell), "motion": str(motion), "vary": vary, "sample": "sobol", "count": count, "seed": seed}
    file.write_text(yaml.safe_dump(named, sort_keys=False), encoding="utf-8")
    return mrts.read_study(file)


def _of_robot(robot, pose, spread, limits, *, planar):
    """Path, value and width of what varies of one arm."""
    arm = f"robots.{robot['name']}"
    base, grasp = (pose(f"{arm}.{frame}", robot.get(frame)) for frame in ("base", "grasp"))
    if planar or robot.get("contact"):  # what turns these is solved one by one
        grasp = [number for number in grasp if ".rpy" not in number[0]]
    numbers = [number for number in base if not planar or ".rpy" not in number[0]] + grasp
    numbers += [(f"{arm}.posture[{joint}]", value, spread) for joint, value in enumerate(robot["posture"])]
    sides = {"torque": robot.get("torque", [])}
    sides |= {f"wrench.{side}": values for side, values in robot.get("wrench", {}).items()}
    return numbers + [
        (f"{arm}.{side}[{place}]", value, limits * abs(value))
        for side, values in sides.items()
        for place, value in enumerate(values)
        if value
    ]
