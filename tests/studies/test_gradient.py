"""The program of a step says of the change of c²⁺ what central differences of `mrts.scale` say."""

import numpy as np
import pytest
import yaml
from draws import draws
from layouts import DATA, Layouts, write_study
from shipped_cells import shipped, shipped_motion

STEP = 1e-5
"""Of central differences [m, rad]: their error is its square, 1e-10, times third derivatives, and rounding of c²⁺,
1e-12, over it."""

SAME_SLOPE = 1e-5
"""Of ∂ ln c²⁺/∂θ [1/m, 1/rad]: what differences leave, of `scale` and of the program's rows."""

SAMPLES = 41
"""Of a motion here."""

UR5_VARY = {
    "distance": {"sets": {"robots.left.base.xyz[0]": -1, "robots.right.base.xyz[0]": 1}, "from": 0.65, "to": 0.85},
    "robots.right.base.xyz[1]": {"from": -0.1, "to": 0.1},
    "robots.right.base.rpy[2]": {"from": 2.9, "to": 3.3},
    "robots.right.grasp.xyz[2]": {"from": -0.04, "to": 0.04},
    "robots.right.grasp.rpy[2]": {"from": -0.2, "to": 0.2},
}
PLANAR_VARY = {
    "robots.left.base.xyz[0]": {"from": -0.2, "to": 0.2},
    "robots.left.base.rpy[2]": {"from": -0.2, "to": 0.2},
    "robots.right.base.xyz[1]": {"from": -0.2, "to": 0.2},
    "robots.right.grasp.xyz[1]": {"from": -0.1, "to": 0.1},
}
MOTORS = {
    "armature": 0.5,
    "friction": {"coulomb": 2.0, "viscous": 3.0},
    "torque_speed": [[0, 160], [1, 160], [5, 30]],
}


def motion_of(folder, cell):
    """The shipped motion of a cell with fewer samples."""
    (folder / "motion.yaml").write_text(yaml.safe_dump(shipped_motion(cell, samples=SAMPLES)), encoding="utf-8")
    return folder / "motion.yaml"


def dual_ur5(folder):
    return write_study(folder, shipped("dual_ur5"), motion_of(folder, "dual_ur5"), UR5_VARY)


def planar(folder):
    return write_study(
        folder, shipped("planar_dual_arm"), DATA / "planar_dual_arm" / "lift.yaml", PLANAR_VARY, reserve=0.1
    )


def squeeze(folder):
    """Pads in tip axes, whose rows turn with the grasps."""
    return write_study(folder, shipped("squeeze"), motion_of(folder, "squeeze"), UR5_VARY)


def with_motors(folder):
    torque = [150, 150, 150, 60, 60, 60]
    return write_study(
        folder, shipped("dual_ur5", motors=MOTORS, torque=torque), motion_of(folder, "dual_ur5"), UR5_VARY
    )


def uncertain_load(folder):
    cell = shipped("dual_ur5")
    cell["object"]["variation"] = {"mass": [0.5, 1.5], "mz": [-0.5, 0.5]}
    return write_study(folder, cell, motion_of(folder, "dual_ur5"), UR5_VARY)


CASES = (dual_ur5, planar, squeeze, with_motors, uncertain_load)


@pytest.mark.parametrize(
    "case",
    [with_motors, *(pytest.param(case, marks=pytest.mark.slow) for case in CASES if case is not with_motors)],
    ids=lambda case: case.__name__,
)
def test_the_slope_is_that_of_scale(case, tmp_path):
    layouts = Layouts.of(case(tmp_path))
    bounds = np.array([parameter.distribution.numbers for parameter in layouts.study.parameters])
    rng = np.random.default_rng(5)
    slopes = []
    while len(slopes) < draws(1):
        values = bounds[:, 0] + rng.uniform(0.2, 0.8, len(bounds)) * (bounds[:, 1] - bounds[:, 0])
        c2 = layouts.c2(values)
        around = np.array(
            [[layouts.c2(values + side * step) for side in (1, -1)] for step in STEP * np.eye(len(bounds))]
        )
        one_sided = np.log(around / c2) * [1, -1] / STEP
        if np.max(np.abs(one_sided[:, 0] - one_sided[:, 1])) > 1e-2:
            continue  # a kink: another row binds on the other side
        slope = layouts.slope(values)
        np.testing.assert_allclose(slope, np.mean(one_sided, axis=1), atol=SAME_SLOPE, rtol=SAME_SLOPE)
        slopes.append(slope)
    assert np.max(np.abs(slopes)) > 0.1
