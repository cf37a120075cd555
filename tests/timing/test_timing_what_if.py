"""What changes to a cell would do to the fastest timing: the same as timing the changed cell."""

import numpy as np
import pytest
from changed_robots import with_left
from gantries import along_x, gantries

import mrts
from mrts.base.rigid_transform import RigidTransform

SAME_TIMING = 1e-7  # regions of speeds are projections, right to 1e-9


def by_text(found):
    return {str(one.change): one for one in found.changes}


def test_each_change_is_what_timing_the_changed_cell_gives(planar_cell, lift):
    cell = planar_cell.with_variation(mass=(0.5, 2.0))
    asked = {"load": "guaranteed", "between": None}
    result = mrts.retime(cell, lift, **asked)
    found = by_text(result.what_if(share=0.05))
    base, grasp = cell.robots[0].T_world_base, cell.robots[0].T_object_tip
    elbow = cell.robots[0].torque_upper * [1, 1.05, 1]
    changed = {
        "left/elbow +5 %": with_left(cell, torque_lower=-elbow, torque_upper=elbow),
        "mass -5 %": cell.with_mass(0.95 * cell.mass),
        "left base y -10 mm": with_left(cell, T_world_base=RigidTransform(base.R, base.p - [0, 0.01, 0])),
        "left grasp x +10 mm": with_left(cell, T_object_tip=RigidTransform(grasp.R, grasp.p - [-0.01, 0, 0])),
    }
    for text, other in changed.items():
        again = mrts.retime(other, lift, **asked)
        assert found[text].after.duration == pytest.approx(again.duration, rel=SAME_TIMING), text
        assert found[text].before.duration == pytest.approx(result.duration, rel=SAME_TIMING)
        assert found[text].after.c2 is None
        assert found[text].after.limits


@pytest.mark.quick
def test_bang_bang_of_two_gantries_in_closed_form(tmp_path):
    """11 kg over 2 m, 40 N of two arms: T = 2 √(2 m / F)."""
    found = mrts.retime(gantries(tmp_path), along_x()).what_if()
    assert found.before.duration == pytest.approx(2 * np.sqrt(2 * 11 / 40), rel=1e-3)
    for text, ratio in (("near/slide_x +10 %", 40 / 42), ("mass +10 %", 11.3 / 11), ("mass -10 %", 10.7 / 11)):
        one = by_text(found)[text]
        assert one.after.duration / one.before.duration == pytest.approx(np.sqrt(ratio), rel=1e-6)
    assert str(by_text(found)["near/slide_x +10 %"]).startswith("near/slide_x +10 %: time -2.41 %, 1.447 s instead of")
    assert str(found).splitlines()[0].endswith("; now 1.483 s")
