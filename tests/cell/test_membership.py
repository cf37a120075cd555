"""What a hand can exert is what forces at the corners of its surfaces, inside friction pyramids, can make."""

import numpy as np
import pytest
from contact_forces import axes_of, least_pressing, least_squeezing

from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.cell.hands import read_contacts

WRENCHES = 2_000
SHAPES = 5

SAME = 1e-7
"""Of normal forces, relative to the largest: HiGHS keeps its rows to 1e-10 of scaled data."""

NEAR = 1e-6
"""Wrenches this near the boundary, as a share of the force, are left to rounding; there are a few in 10 000."""


def shapes(kind):
    """A few shapes of a kind with their random wrenches, some of them on the boundary."""
    rng = np.random.default_rng([WRENCHES, *kind.encode()])
    for number in range(SHAPES):
        normal = rng.normal(size=3) if number else np.eye(3)[rng.integers(3)]
        mu, widths = rng.uniform(0.1, 1.2), rng.uniform(0.005, 0.1, 2)
        a, b, n = axes_of(normal)
        frame = np.block([[np.array([a, b, n]), np.zeros((3, 3))], [np.zeros((3, 3)), np.array([a, b, n])]])
        reach = np.array([mu, mu, 1.0, widths[1], widths[0], mu * sum(widths)])
        demands = rng.uniform(-1, 1, (WRENCHES // SHAPES, 6)) * (rng.random((WRENCHES // SHAPES, 6)) < 0.8)
        yield rng, normal, float(mu), widths.tolist(), n, (demands * reach) @ frame


def made(kind, components=WRENCH_COMPONENTS, **keys):
    return read_contacts("cell", "contact", [{kind: keys}], components, np.eye(3))[0]


def value(contact, wrenches):
    """Rows of the contact, those of friction with what the pressing has added."""
    return wrenches @ contact.A.T


def holds(contact, wrenches):
    rows = value(contact, wrenches)
    return np.all((contact.lower <= rows) & (rows <= contact.upper), axis=1)


def test_a_pad_holds_what_its_corners_can_make():
    for rng, normal, mu, widths, n, demands in shapes("pad"):
        force = np.sort(rng.uniform(0, 300, 2)).tolist()
        given = made("pad", friction=mu * np.sqrt(2), normal=normal, half_width=widths, force=force)
        wrenches = demands * 100
        lacks = value(given, wrenches)[:, 1:] + (wrenches[:, :3] @ n)[:, None]
        least = least_pressing(wrenches, normal, widths, mu)
        np.testing.assert_allclose(np.max(lacks, axis=1), least, atol=SAME * 300)
        assert given.rows[0] == "normal force"
        pressed = rng.uniform(0, 1.2, (len(wrenches), 1)) * least.max()
        pressed[::10, 0] = least[::10] * rng.choice([1 - NEAR, 1 + NEAR], len(least[::10]))  # near the boundary
        whole = wrenches + np.hstack([(pressed - wrenches[:, :3] @ n[:, None]) * n, np.zeros((len(wrenches), 3))])
        wanted = (pressed[:, 0] >= least) & (pressed[:, 0] >= force[0]) & (pressed[:, 0] <= force[1])
        assert 0 < np.sum(wanted) < len(wanted)
        assert np.array_equal(holds(given, whole), wanted)


@pytest.mark.quick
def test_a_suction_cup_holds_what_its_lip_can_make_inside_its_circle():
    for rng, normal, mu, (radius, _), n, demands in shapes("suction"):
        holding = rng.uniform(20, 200)
        cup = made("suction", holding_force=holding, friction=mu * np.sqrt(2), radius=radius, normal=normal)
        wrenches = demands * [holding] * np.array([1, 1, 1, *(radius / 0.05,) * 3])
        least = least_pressing(wrenches, normal, [radius / np.sqrt(2)] * 2, mu)
        lip = holding + wrenches[:, :3] @ n
        clear = np.abs(lip - least) > NEAR * holding
        assert np.array_equal(holds(cup, wrenches)[clear], (lip >= least)[clear])
        assert np.mean(clear) > 0.99
        assert 0 < np.sum(lip >= least) < len(least)


def test_a_gripper_holds_what_both_pads_can_make():
    for rng, axis, mu, widths, _, demands in shapes("gripper"):
        force = rng.uniform(10, 200)
        given = made("gripper", force=force, friction=mu * np.sqrt(2), half_width=widths, axis=axis)
        wrenches = demands * 2 * force
        least = least_squeezing(wrenches, axis, widths, mu)
        np.testing.assert_allclose(np.max(np.abs(value(given, wrenches)), axis=1), least, atol=SAME * least.max())
        assert 0 < np.sum(holds(given, wrenches)) < len(wrenches)


@pytest.mark.parametrize("plane_axis", range(3))
def test_planar_hands_are_spatial_ones_that_stay_in_the_plane(plane_axis):
    """Their rows are those of corner forces in the plane, whose friction has one direction."""
    rng = np.random.default_rng(plane_axis)
    first, second = (axis for axis in range(3) if axis != plane_axis)
    components = tuple(WRENCH_COMPONENTS[place] for place in (first, second, 3 + plane_axis))
    for _ in range(20):
        normal, mu, width = np.zeros(3), rng.uniform(0.1, 1), rng.uniform(0.01, 0.1)
        normal[[first, second]] = rng.normal(size=2)
        n = normal / np.linalg.norm(normal)
        along = np.cross(np.eye(3)[plane_axis], n)
        wrenches = np.zeros((200, 6))
        forces = rng.normal(size=(200, 2, 1)) * n + rng.normal(size=(200, 2, 1)) * along * mu
        for place, sign in enumerate((-1, 1)):
            wrenches[:, :3] += forces[:, place]
            wrenches[:, 3:] += np.cross(sign * width * along, forces[:, place])
        pressed, f_a = wrenches[:, :3] @ n, wrenches[:, :3] @ along
        needed = np.maximum(np.abs(f_a) / mu, np.abs(wrenches[:, 3 + plane_axis]) / width)
        planar = wrenches[:, [first, second, 3 + plane_axis]]
        common = {"friction": mu, "components": components}
        flat = made("pad", normal=normal, half_width=[width], force=[0, 1000], **common)
        cup = made("suction", holding_force=2.0, radius=width, normal=normal, **common)
        jaws = made("gripper", force=1.0, half_width=[width], axis=normal, **common)
        assert np.array_equal(holds(flat, planar), pressed >= needed)
        assert np.array_equal(holds(cup, planar), pressed + 2 >= needed)
        assert np.array_equal(holds(jaws, planar), np.maximum(needed, np.abs(pressed)) <= 2)
        assert len(flat.rows) == 5
