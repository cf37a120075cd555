"""The program of a step says of the change of c²⁺ what central differences of `mrts.scale` say."""

import numpy as np
import pytest
import yaml
from draws import draws
from layouts import Layouts, write_study
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


CASES = {
    "dual": {"cell": "dual_ur5"},
    "planar": {"cell": "planar_dual_arm", "reserve": 0.1},
    "pads in tip axes, which turn with the grasps": {"cell": "squeeze"},
    "motors": {"cell": "dual_ur5", "motors": MOTORS, "torque": [150, 150, 150, 60, 60, 60]},
    "uncertain load": {"cell": "dual_ur5", "variation": {"mass": [0.5, 1.5], "mz": [-0.5, 0.5]}},
}


def study_of(folder, cell, variation=None, reserve=None, **robots):
    """A study of a shipped cell, its motion with fewer samples."""
    keys, motion = shipped(cell, **robots), folder / "motion.yaml"
    keys["object"] |= {} if variation is None else {"variation": variation}
    motion.write_text(yaml.safe_dump(shipped_motion(cell, samples=SAMPLES)), encoding="utf-8")
    vary = PLANAR_VARY if cell == "planar_dual_arm" else UR5_VARY
    return write_study(folder, keys, motion, vary, **({} if reserve is None else {"reserve": reserve}))


@pytest.mark.parametrize(
    "name", ["motors", *(pytest.param(name, marks=pytest.mark.slow) for name in CASES if name != "motors")]
)
def test_the_slope_is_that_of_scale(name, tmp_path):
    layouts = Layouts.of(study_of(tmp_path, **CASES[name]))
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
