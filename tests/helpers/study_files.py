"""Study files written for a test."""

import yaml
from conftest import DATA

import mrts


def planar_study(folder, text, *, cell=DATA / "cell.yaml", motion=DATA / "lift.yaml"):
    """Read a study of the planar cell; `text` is the file without the two names."""
    path = folder / "study.yaml"
    path.write_text(f"cell: {cell}\nmotion: {motion}\n{text}\n", encoding="utf-8")
    return mrts.read_study(path)


def wide_study(folder, cell, motion, *, spread, count, seed=1, limits=0.2, mass=(0.7, 1.3), inertia=1e-3):
    """Read a study that varies every number that native calls take: poses, gravity, object, postures, limits, motion.

    Args:
        folder: For the study file.
        cell: The cell file.
        motion: The motion file, from pose to pose.
        spread: How far poses and postures go, each way [m, rad].
        count: Number of variants.
        seed: Of what is drawn.
        limits: Share by which limits go, each way.
        mass: Range of the factor of the mass.
        inertia: Share by which moments go, each way: those of a thin body soon break a rule.
    """
    files = {"cell": yaml.safe_load(cell.read_text()), "motion": yaml.safe_load(motion.read_text())}
    plane = files["cell"].get("plane")
    axes = ["xyz".index(axis) for axis in plane or "xyz"]
    turns = range(3) if plane is None else [({0, 1, 2} - set(axes)).pop()]
    vary = {}

    def both(path, value, width):
        if value is not None and width > 0:
            vary[path] = {"from": value - width, "to": value + width}

    def pose(path, given):
        for part, places in (("xyz", axes), ("rpy", turns)):
            for axis in places:
                both(f"{path}.{part}[{axis}]", (given or {}).get(part, [0, 0, 0])[axis], spread)

    for robot in files["cell"]["robots"]:
        arm = f"robots.{robot['name']}"
        pose(f"{arm}.base", robot.get("base"))
        pose(f"{arm}.grasp", robot.get("grasp"))
        for joint, value in enumerate(robot["posture"]):
            both(f"{arm}.posture[{joint}]", value, spread)
        for joint, value in enumerate(robot.get("torque", [])):
            both(f"{arm}.torque[{joint}]", value, limits * value)
        for side, values in robot.get("wrench", {}).items():
            for component, value in enumerate(values):
                both(f"{arm}.wrench.{side}[{component}]", value, limits * abs(value or 0))
    carried = files["cell"]["object"]
    vary["object.mass"] = {"from": mass[0] * carried["mass"], "to": mass[1] * carried["mass"]}
    if not isinstance(carried["inertia"][0], list):
        for axis, value in enumerate(carried["inertia"]):
            both(f"object.inertia[{axis}]", value, inertia * value)
    for axis in axes:
        both(f"gravity[{axis}]", files["cell"]["gravity"][axis], 0.3)
    both("motion.duration", files["motion"]["duration"], 0.1 * files["motion"]["duration"])
    for end in ("start", "end"):
        pose(f"motion.{end}", files["motion"][end])
    path = folder / "study.yaml"
    named = {"cell": str(cell), "motion": str(motion), "vary": vary, "sample": "lhs", "count": count, "seed": seed}
    path.write_text(yaml.safe_dump(named, sort_keys=False), encoding="utf-8")
    return mrts.read_study(path)
