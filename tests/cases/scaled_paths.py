"""The shipped motions on paths of any length."""

import numpy as np
from shipped_cells import sampled, shipped_motion


def scaled_path(name, length, samples, profile):
    """The shipped motion of a cell, cut or stretched to a length."""
    given = shipped_motion(name, samples=samples, profile=profile)
    start, end = (np.array(given[key]["xyz"]) for key in ("start", "end"))
    factor = length / np.linalg.norm(end - start)
    given["end"] = {"xyz": (start + factor * (end - start)).tolist()} | {
        key: (factor * np.array(value)).tolist() for key, value in given["end"].items() if key == "rpy"
    }
    return sampled(given)
