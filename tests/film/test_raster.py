"""Triangles to pixels, against the geometry that they stand for."""

import numpy as np
import pytest

from mrts.film.camera import framing_camera
from mrts.film.raster import drawn
from mrts.film.solids import ball, faceted, tube

pytestmark = pytest.mark.quick

SIZE = (160, 120)
UP, BACKWARD = np.array([0.0, 0.0, 1.0]), np.array([0.2, -1.0, 0.3])
RED, BLUE = (220, 30, 30), (30, 30, 220)
LAMP = np.array([0.0, -0.6, 0.8])

MOST_SPARE = 0.15
"""Free at the narrower sides, as a share of the picture: it stands a tenth farther away than it must."""

EDGE = 0.03
"""Share of a ball's pixels that may differ from those of a true ball: it is drawn with 20 sides."""


def seen(solids, camera):
    """Which pixels are red, and which blue."""
    picture = drawn(np.full((SIZE[1], SIZE[0], 3), 255, dtype=np.float32), camera, solids, LAMP)
    return picture[:, :, 0] > 2 * picture[:, :, 2], picture[:, :, 2] > 2 * picture[:, :, 0]


def test_a_camera_has_all_points_in_its_picture_and_none_would_do_nearer():
    rng = np.random.default_rng(1)
    for _ in range(20):
        points = rng.normal(size=(30, 3)) * rng.uniform(0.1, 2, 3) + rng.normal(size=3)
        camera = framing_camera(points, rng.normal(size=3) * [1, 1, 0.3], UP, SIZE)
        right, down, away = camera.seen(points).T
        assert np.all(away > 0)
        assert np.all((right > 0) & (right < SIZE[0]) & (down > 0) & (down < SIZE[1]))
        spare = right.min() / SIZE[0], down.min() / SIZE[1]
        assert min(spare) < MOST_SPARE
        assert abs(right.min() - (SIZE[0] - right.max())) < 2  # as much room on the left as on the right
        assert camera.axes @ camera.axes.T == pytest.approx(np.eye(3), abs=1e-12)


def test_a_ball_covers_the_pixels_whose_rays_meet_it():
    center, radius = np.array([0.3, 0.1, 0.2]), 0.4
    camera = framing_camera(center + 1.2 * radius * np.vstack([np.eye(3), -np.eye(3)]), BACKWARD, UP, SIZE)
    rays = camera.rays(np.arange(SIZE[0] * SIZE[1]))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    off = np.linalg.norm(np.cross(center - camera.position, rays), axis=1)
    meets = (off < radius).reshape(SIZE[1], SIZE[0])
    red, _ = seen([ball(center, radius, RED)], camera)
    assert np.count_nonzero(red != meets) < EDGE * np.count_nonzero(meets)
    assert np.count_nonzero(meets) > 3000


@pytest.mark.parametrize("order", [1, -1])
def test_what_is_nearer_hides_what_is_behind_whatever_comes_first(order):
    """A bar that pierces a plate: on one side of the plate it is before it, on the other behind."""
    plate = faceted(np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]]), np.array([[0, 1, 2], [0, 2, 3]]), RED)
    bar = tube(np.array([0.0, -1, 0.1]), np.array([0.0, 1, 0.1]), (0.1, 0.1), BLUE)
    camera = framing_camera(np.concatenate([plate.points, bar.points]), np.array([0.6, -1, 0.2]), UP, SIZE)
    red, blue = seen([plate, bar][::order], camera)
    for depth, is_seen in ((-0.7, True), (-0.3, True), (0.3, False), (0.7, False)):
        right, down, _ = camera.seen(np.array([[0.0, depth, 0.1]]))[0]
        assert bool(blue[int(down), int(right)]) is is_seen, depth
    corner = camera.seen(np.array([[-0.9, 0, -0.9]]))[0]
    assert red[int(corner[1]), int(corner[0])]


def test_what_is_behind_the_camera_or_seen_edgewise_is_not_drawn():
    camera = framing_camera(np.vstack([np.eye(3), -np.eye(3)]), BACKWARD, UP, SIZE)
    behind = ball(camera.position - 2 * camera.axes[2], 0.5, RED)
    edge = camera.position + np.array([[1.0], [2.0], [3.0]]) * camera.axes[2] + np.array([[0], [0], [0.01]]) * UP * 0
    line = faceted(edge, np.array([[0, 1, 2]]), BLUE)
    red, blue = seen([behind, line, ball(np.zeros(3), 1e-9, RED)], camera)
    assert not red.any()
    assert not blue.any()
