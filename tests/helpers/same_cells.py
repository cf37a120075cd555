"""Whether two cells are one, to the last bit."""

from mrts.cell.cell_keys import manifest_of


def same_cell(one, other):
    """Whether two cells agree in all that a manifest says but where their URDFs are."""
    ours, theirs = (_numbers(cell) for cell in (one, other))
    return ours == theirs and one.geometry.tobytes() == other.geometry.tobytes()


def _numbers(cell):
    said = manifest_of(cell).model_dump(exclude={"content_sha256"})
    for robot, now in zip(said["robots"], cell.robots, strict=True):
        del robot["source"]["urdf"]
        robot["source"] |= {"effort": now.has_urdf_torque, "friction": now.has_urdf_friction}
    return said
