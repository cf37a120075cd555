"""Study files written for a test."""

from conftest import DATA

import mrts


def planar_study(folder, text, *, cell=DATA / "cell.yaml", motion=DATA / "lift.yaml"):
    """Read a study of the planar cell; `text` is the file without the two names."""
    path = folder / "study.yaml"
    path.write_text(f"cell: {cell}\nmotion: {motion}\n{text}\n", encoding="utf-8")
    return mrts.read_study(path)
