"""Cell files of any keys, and the shipped cells and motions, changed."""

from pathlib import Path

import numpy as np
import yaml

import mrts
from mrts.cell.generation import generated_in_cache
from mrts.kernel.c_text import cell_macros

DATA = Path(mrts.__file__).parent / "data"


def shipped(name="planar_dual_arm", **robots):
    """Keys of a shipped cell file, its URDFs by their whole paths, some keys of all its robots changed."""
    folder = DATA / name
    keys = yaml.safe_load((folder / "cell.yaml").read_text(encoding="utf-8"))
    changed = [robot | robots | {"urdf": str((folder / robot["urdf"]).resolve())} for robot in keys["robots"]]
    return keys | {"robots": changed}


def cell_file(folder, keys):
    """A cell file of these keys."""
    (folder / "cell.yaml").write_text(yaml.safe_dump(keys, allow_unicode=True), encoding="utf-8")
    return folder / "cell.yaml"


def cell_of_arms(folder, *robots, name="arms", gravity=(0, 0, -9.81), mass=1.0, inertia=(0.01, 0.01, 0.01), **keys):
    """A cell file of these robots."""
    carried = {"mass": mass, "inertia": list(inertia)}
    return cell_file(folder, {"name": name, "gravity": list(gravity), "object": carried, "robots": list(robots)} | keys)


def changed_cell(folder, change, name="planar_dual_arm"):
    """The file of a shipped cell after a change of its keys."""
    keys = shipped(name)
    change(keys)
    return cell_file(folder, keys)


def shipped_motion(name="planar_dual_arm", **keys):
    """Keys of the motion file of a shipped cell, some changed."""
    folder = DATA / name
    path = next(path for path in (folder / "lift.yaml", folder / "lift_and_turn.yaml") if path.exists())
    return yaml.safe_load(path.read_text(encoding="utf-8")) | keys


def sizes_of(name):
    """Flags of a compiler that define the sizes of a shipped cell for the kernel."""
    manifest, _ = generated_in_cache(DATA / name / "cell.yaml")
    return [f"-D{macro}={value}" for macro, value in cell_macros(manifest).items()]


def scaled_path(name, length, samples, profile):
    """The shipped motion of a cell, cut or stretched to a length."""
    given = shipped_motion(name, samples=samples, profile=profile)
    start, end = (np.array(given[key]["xyz"]) for key in ("start", "end"))
    factor = length / np.linalg.norm(end - start)
    given["end"] = {"xyz": (start + factor * (end - start)).tolist()} | {
        key: (factor * np.array(value)).tolist() for key, value in given["end"].items() if key == "rpy"
    }
    return mrts.load_motion(given)


def still_motion(xyz, **keys):
    """An object that rests."""
    here = {"xyz": list(map(float, xyz))}
    return mrts.load_motion({"duration": 1.0, "samples": 11, "profile": "quintic", "start": here, "end": here} | keys)
