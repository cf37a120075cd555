"""Results of every kind that people look at: outcomes, numbers of robots, kinds of joints, awkward names."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell
from conftest import UR5
from random_motors import with_all_rates
from shipped_cells import still_motion

import mrts
from mrts.cell.cell import cell_of

KINDS = (
    "planar", "spatial", "infeasible", "empty", "least speed", "unbounded", "guaranteed", "infeasible load",
    "possible", "fixed rule", "one arm", "four arms", "sliding joints", "awkward names", "smooth", "rates", "what if",
)  # fmt: skip

AWKWARD = "</script><script>window.broken=1</script>"
UGLY_JOINTS = tuple(f"_<img src=x onerror=window.broken=1>$x$ & joint {number} with a long name" for number in range(3))


def as_if_generated(cell, **changes):
    """The cell with other entries in its manifest, its functions as they are."""
    generated = cell.generated
    manifest = generated.manifest.model_copy(update={"cell": replace(generated.manifest.cell, **changes)})
    return cell_of(replace(generated, manifest=manifest))


def renamed(cell, name, robots, joints):
    """The cell as if it had been generated with other names, as no cell file could give them."""
    records = []
    for robot, other in zip(cell.generated.manifest.cell.robots, robots, strict=True):
        records.append(replace(robot, name=other, joints=joints))
    return as_if_generated(cell, name=name, robots=tuple(records))


def with_awkward_names(cell):
    """The cell with names of joints as a URDF may give them."""
    return renamed(cell, "awkward", ("left", "right"), (AWKWARD, *UGLY_JOINTS[1:]))


def random_result(make, seed, folder, arms):
    """A feasible result of a seeded random cell."""
    case = make(np.random.default_rng(seed), folder, arms)
    return mrts.scale(case.cell, case.motion)


def braking_only(cell, lift, first):
    """The end of the lift with an object too heavy to hold: it must be thrown."""
    parts = (lift.position, lift.rotation, lift.twist, lift.acceleration)
    motion = mrts.ObjectMotion(lift.time[first:] - lift.time[first], *(part[first:] for part in parts))
    return mrts.scale(cell.with_mass(24.0), motion)


def with_changes(result, **steps):
    """The result with what changes to its cell would do, by other steps than mrts's own."""
    with pytest.MonkeyPatch.context() as patched:
        for name, step in steps.items():
            patched.setattr(f"mrts.cell.cell_change.{name}", step)
        return replace(result, changes=result.what_if())


def result_of(kind, planar, spatial, lift, folder):
    """One of `KINDS`."""
    uncertain = planar.with_variation(mass=(0.2, 6.0), izz=(0.5, 2.0), mx=(-0.02, 0.02))
    makers = {
        "planar": lambda: mrts.scale(planar, lift),
        "spatial": lambda: mrts.scale(spatial, mrts.load_motion(UR5 / "lift_and_turn.yaml")),
        "infeasible": lambda: mrts.scale(planar.with_mass(24.0), lift),
        "empty": lambda: braking_only(planar, lift, 53),  # slower than the end allows is too slow at the start
        "least speed": lambda: braking_only(planar, lift, 60),
        "unbounded": lambda: mrts.scale(planar, still_motion(lift.position[0])),
        "guaranteed": lambda: mrts.scale(uncertain, lift),
        "infeasible load": lambda: mrts.scale(planar.with_variation(mass=(1.0, 48.0)), lift),
        "possible": lambda: mrts.scale(planar.with_variation(mass=(0.2, 6.0)), lift, load="possible"),
        "fixed rule": lambda: mrts.scale(planar.with_variation(mass=(0.2, 6.0)), lift, sharing=mrts.LoadSharing()),
        "one arm": lambda: random_result(random_planar_cell, 4, folder, 1),
        "four arms": lambda: random_result(random_planar_cell, 3, folder, 4),
        "sliding joints": lambda: random_result(random_spatial_cell, 2, folder, 2),
        "awkward names": lambda: with_changes(mrts.scale(with_awkward_names(planar), lift)),
        "smooth": lambda: mrts.retime(with_all_rates(planar), lift, rates=11.0).retimed,
        "rates": lambda: mrts.scale(with_all_rates(planar), lift),  # told, not kept
        "what if": lambda: with_changes(mrts.scale(planar.with_mass(7.0), lift), SHARE=0.8, SHIFT=0.9),
    }
    assert tuple(makers) == KINDS
    return makers[kind]()
