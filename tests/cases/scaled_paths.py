"""The shipped motions on paths of any length."""

import numpy as np
import yaml
from conftest import DATA

import mrts

FILES = {"planar_dual_arm": "lift.yaml", "dual_ur5": "lift_and_turn.yaml"}


def scaled_path(name, length, samples, profile):
    """The shipped motion of a cell, cut or stretched to a length."""
    given = yaml.safe_load((DATA.parent / name / FILES[name]).read_text())
    start, end = (np.array(given[key]["xyz"]) for key in ("start", "end"))
    factor = length / np.linalg.norm(end - start)
    given["end"] = {"xyz": (start + factor * (end - start)).tolist()} | {
        key: (factor * np.array(value)).tolist() for key, value in given["end"].items() if key == "rpy"
    }
    given |= {"samples": samples, "profile": profile}
    return mrts.sample_motion(mrts.MotionDescription.model_validate(given))
