"""Study files written for a test."""

import yaml
from conftest import DATA

import mrts


def planar_study(folder, text, *, cell=DATA / "cell.yaml", motion=DATA / "lift.yaml"):
    """Read a study of the planar cell; `text` is the file without the two names, files may be given by their keys."""
    paths = []
    for name, file in (("cell.yaml", cell), ("motion.yaml", motion)):
        if isinstance(file, dict):
            (folder / name).write_text(yaml.safe_dump(file), encoding="utf-8")
        paths.append(folder / name if isinstance(file, dict) else file)
    path = folder / "study.yaml"
    path.write_text(f"cell: {paths[0]}\nmotion: {paths[1]}\n{text}\n", encoding="utf-8")
    return mrts.read_study(path)


def write_study(folder, cell, motion, vary, **keys):
    """A study file of the cell of these keys."""
    asked = {"vary": vary, "sample": "sobol", "count": 16} | keys
    return planar_study(folder, yaml.safe_dump(asked), cell=cell, motion=motion).path
