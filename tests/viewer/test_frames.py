"""What a page is sent while a motion plays, counted through a raw websocket by a clock of the test's own."""

import numpy as np
import pytest
from conftest import DATA
from scipy.spatial.transform import Rotation
from viewer_socket import connected, messages_of

import mrts
from mrts.viewer.server import close_server, open_server
from mrts.viewer.viewer import FRAME, Viewer
from mrts.viewer.workbench.choices import Given
from mrts.viewer.workbench.held_poses import tip_pose
from mrts.viewer.workbench.workbench import Workbench

UR5 = DATA.parent / "dual_ur5"
PATIENCE = 60.0
"""[s]"""

WANTED = 30
"""Frames a second."""

MOST_PARTS = 40
"""Of a frame; viser cuts at 128, and then a page draws half of it."""

BLENDED = 1e-3
"""By how much less a turn between samples is than a rotation: the square of a step, which is at most 0.06 rad here."""


def frame_after(opened):
    """Parts of the next message in which the object moves."""
    while True:
        parts = messages_of(opened.recv(timeout=PATIENCE))
        if any(part.get("name") == "/object" and part["type"] == "SetPositionMessage" for part in parts):
            return parts


@pytest.fixture(scope="module")
def viewer(dual_ur5):
    server = open_server("127.0.0.1", 0, "test")
    shown = Viewer(server, Workbench(Given(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))), {}, pytest.fail)
    yield shown
    shown.close()
    close_server(server)


def test_a_second_of_playing_is_thirty_frames_each_whole(viewer):
    """Each step of the viewer is one message with every part that moves, at the slowest pace too."""
    moving = {"/object", "/hands/left", "/hands/right", "/carried", "/carried/forces"}
    moving |= {f"/arms/{arm}/body{body}" for arm in ("left", "right") for body in range(1, 7)}
    pace = next(handle for handle in viewer.server.controls.values() if getattr(handle, "label", "") == "pace")
    for pace.value in ("1/10", "1/50"):
        with connected(viewer.server.url) as opened:
            viewer.playback.toggle()
            viewer.step(FRAME)
            frame_after(opened)
            frames, clock, seen = 0, 0.0, set()
            while clock < 1:
                viewer.step(FRAME)
                clock += FRAME
                parts = frame_after(opened)
                frames += moving <= {part.get("name") for part in parts}
                assert sum("position" in part or "wxyz" in part for part in parts) <= MOST_PARTS
                position = next(part["position"] for part in parts if part.get("name") == "/object")
                seen.add(tuple(position))
            viewer.playback.toggle()
            viewer.step(FRAME)
        assert frames >= WANTED
        assert len(seen) >= WANTED


def test_between_samples_hands_stay_at_their_grasps_and_a_pause_is_a_sample(viewer):
    state = viewer.state
    course = state.scene
    for place in (3.25, 50.5, 99.99):
        moment = course.moment(place)
        low, high = int(place), int(place) + 1
        between = course.position[low] + (place - low) * (course.position[high] - course.position[low])
        np.testing.assert_allclose(moment.position, between)
        for robot, (R, p) in zip(state.result.cell.robots, moment.bodies, strict=True):
            grasp = moment.position + moment.rotation @ robot.T_object_tip.p
            np.testing.assert_allclose(tip_pose(robot, R, p)[1], grasp, atol=1e-6)
            np.testing.assert_allclose(np.linalg.det(R), 1, atol=BLENDED)
    viewer.playback.toggle()
    viewer.step(0.4 * FRAME)
    viewer.playback.toggle()
    viewer.step(FRAME)
    body = viewer.server.scene.get_handle_by_name("/object")
    np.testing.assert_array_equal(body.position, course.position[state.sample])
    turned = Rotation.from_quat(np.roll(body.wxyz, -1)).as_matrix()
    np.testing.assert_allclose(turned, course.rotation[state.sample], atol=1e-12)
