"""The kernel's widening of limits along a motion against qpOASES, and its motion between samples against Python's."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from random_motors import drawn_motors
from shipped_cells import shipped_motion

import mrts
from mrts.following.coordinated_motion import carried_by_first
from mrts.following.denser_motion import velocity_polynomials
from mrts.program.infeasibility import motion_widening, widening_at
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import motion_ranges
from mrts.timing.path_pieces import PLACES, path_pieces
from mrts.timing.result import TimedPiece, between_path_samples

SHIPPED = ("planar_dual_arm", "dual_ur5", "squeeze")
AGREES = 1e-8  # both solve the same programs, each to 1e-9 of a limit
SAME_MOTION = 1e-10  # of the largest entry: a place in its segment is a difference of parameters in one of them
SAMPLES = 300  # more than a chunk of the kernel, so that two threads have something to share


def followed(name, samples=SAMPLES):
    cell = mrts.load_cell(DATA.parent / name / "cell.yaml")
    return cell, mrts.follow_object(cell, mrts.load_motion(shipped_motion(name, samples=samples)))


def changed(cell, how, rng):
    return {
        "given": lambda: cell,
        "velocities apart": cell.without_velocity_limits,
        "motors": lambda: drawn_motors(rng, cell),
        "reserve": lambda: cell.with_reserve(0.1),
        "heavier": lambda: replace(cell, load=cell.load * 3),
    }[how]()


@pytest.mark.parametrize("how", ["given", "velocities apart", "motors", "reserve", "heavier"])
@pytest.mark.parametrize("name", SHIPPED)
def test_the_widening_is_the_one_of_highs(name, how):
    """At c² that samples admit with room, hardly, and not at all, one after the other."""
    rng = np.random.default_rng([5, len(how), len(name)])
    given, motion = followed(name)
    cell = changed(given, how, rng)
    ranges = motion_ranges(motion_rows(cell, motion))
    most = float(np.min(ranges.upper, where=ranges.upper > 0, initial=100.0))
    c2 = most * rng.choice([0.3, 0.999, 1.0, 1.001, 1.5, 4.0], size=motion.samples)
    c2[: motion.samples // 3] = most
    rows = motion_rows(cell, motion)
    theirs = widening_at(replace(build_sample_problem(rows), solver="qpsol:qpoases"), c2[:, None])
    found = motion_widening(rows, c2)
    np.testing.assert_allclose(found, theirs, atol=AGREES, rtol=AGREES)
    assert np.max(theirs) > 0.1
    assert how in {"motors", "heavier"} or np.min(theirs) < AGREES


def timed(cell, motion):
    """A piece of the path with a speed and a rate that change along it."""
    (piece,) = path_pieces(cell, motion)
    n = len(piece.speed)
    x = 1 + np.sin(np.linspace(0, 3, n))
    return TimedPiece(piece=piece, x=x, rates=np.column_stack([np.linspace(-1, 1, n - 1), np.linspace(0, 2, n - 1)]))


def places_in_numpy(cell, part):
    """On polynomials of q' along the path, played at x and x'/2, which is linear inside a segment; eq. (10)."""
    path, step = part.piece.path, part.piece.step[:, None]
    s = (path.object.time[:-1, None] + step * PLACES).ravel()
    rate = (part.rates[:, :1] + np.diff(part.rates, axis=1) * PLACES).ravel()[:, None]
    start = part.x[:-1, None] + step * PLACES * part.rates[:, :1]
    x = (start + step * PLACES * rate.reshape(step.shape[0], -1)).ravel()[:, None]
    q, dq, ddq = velocity_polynomials(path.object.time, (path.q, path.dq, path.ddq), s)
    return carried_by_first(cell, s - s[0], q, dq * np.sqrt(x), ddq * x + dq * rate)


@pytest.mark.parametrize("name", SHIPPED)
def test_places_between_samples_are_those_of_numpy(name):
    """Joints, and the object that the first arm carries."""
    cell, motion = followed(name, 41)
    part = timed(cell, motion)
    found = between_path_samples(cell, part, np.arange(len(part.rates)))
    theirs = places_in_numpy(cell, part)
    for ours, other in (
        *((getattr(found, of), getattr(theirs, of)) for of in ("q", "dq", "ddq")),
        *((getattr(found.object, of), getattr(theirs.object, of)) for of in ("time", "position", "rotation")),
        *((getattr(found.object, of), getattr(theirs.object, of)) for of in ("twist", "acceleration")),
    ):
        np.testing.assert_allclose(ours, other, atol=SAME_MOTION * np.max(np.abs(other)), rtol=0)
