"""Cameras that have all of a motion in their picture."""

import numpy as np
import pytest

import mrts
from mrts.scene.cell_view import FIELD_OF_VIEW, CellView

pytestmark = pytest.mark.quick

UP, ASPECT = np.array([0.0, 0.0, 1.0]), 4 / 3

MOST_SPARE = 0.2
"""Free at the narrower sides, as a share of the picture: a camera stands a little farther away than it must."""


def in_picture(points, backward):
    """Where points are, from -1 to 1 to either side, how far away, and the camera."""
    view = CellView(UP, np.array(backward, dtype=float), points, np.zeros(3), 1.0)
    camera = view.camera(ASPECT)
    along = (points - camera.position) @ camera.axes.T
    return along[:, :2] / along[:, 2:] / np.tan(FIELD_OF_VIEW / 2) / [ASPECT, 1], along[:, 2], camera


def test_a_camera_has_all_points_in_its_picture_and_none_would_do_nearer():
    rng = np.random.default_rng(1)
    for _ in range(20):
        points = rng.normal(size=(30, 3)) * rng.uniform(0.1, 2, 3) + rng.normal(size=3)
        seen, away, camera = in_picture(points, rng.normal(size=3) * [1, 1, 0.3])
        assert np.all(away > 0)
        assert np.all(np.abs(seen) < 1)
        assert np.min((1 - np.max(np.abs(seen), axis=0)) / 2) < MOST_SPARE
        np.testing.assert_allclose(seen.max(axis=0), -seen.min(axis=0), atol=1e-6)  # as much room on both sides
        np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-12)
        ahead = camera.target - camera.position
        np.testing.assert_allclose(ahead / np.linalg.norm(ahead), camera.axes[2], atol=1e-9)


def test_a_camera_may_look_from_right_above_but_from_somewhere():
    points = np.random.default_rng(1).uniform(-1, 1, (50, 3))
    for backward in ([0, 0, 1], [1e-9, 0, 2], [0, 0, -1], [0.005, 0, 1], [1, 0.2, 0.1]):
        seen, away, _ = in_picture(points, backward)
        assert np.all(away > 0), backward
        assert np.all(np.abs(seen) < 1), backward
    for backward in ([0, 0, 0], [np.nan, 0, 1]):
        with pytest.raises(mrts.InputError, match="must have a direction"):
            in_picture(points, backward)
