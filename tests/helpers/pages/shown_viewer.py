"""A viewer without a browser: its server, its workbench, and its controls by label."""

import time
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
from conftest import DATA, UR5
from published_robots import ROBOTS
from shipped_cells import cell_file, shipped

import mrts
from mrts.motion.motion_file import described_motion
from mrts.viewer.server import close_server, open_server
from mrts.viewer.viewer import FRAME, Viewer
from mrts.viewer.workbench import Given, Workbench

PATIENCE = 60.0
"""[s]"""


@contextmanager
def shown_viewer(bench, *, warn=pytest.fail):
    """The viewer of a workbench, of what one is given, or of the state of a saved result."""
    bench = Workbench(bench) if isinstance(bench, Given) else bench
    server = open_server("127.0.0.1", 0, "test")
    try:
        shown = Viewer(server, bench, warn)
        controls = {getattr(handle, "label", ""): handle for handle in server.controls.values()}
        yield SimpleNamespace(server=server, shown=shown, bench=bench, controls=controls, url=server.url)
        shown.close()
    finally:
        close_server(server)


def settle(shown):
    """Step until every question is answered and shown."""
    end = time.monotonic() + PATIENCE
    shown.step(FRAME)
    while shown.bench is not None and shown.bench.waits and time.monotonic() < end:
        time.sleep(FRAME / 3)
        shown.step(FRAME)
    shown.step(0.0)


def spatial_given(cell):
    """Of the dual UR5 and its motion."""
    path = UR5 / "lift_and_turn.yaml"
    return Given(cell, mrts.load_motion(path), described_motion(path))


def planar_given(cell):
    """Of the planar cell and its lift."""
    return Given(cell, mrts.load_motion(DATA / "lift.yaml"), described_motion(DATA / "lift.yaml"))


def news_of(bench):
    """All that is taken until there is nothing left to do."""
    end, taken = time.monotonic() + PATIENCE, []
    while True:
        waits = bench.waits
        taken += bench.take()
        if not waits:
            return taken
        assert time.monotonic() < end
        time.sleep(0.001)


def answered(bench):
    """The newest answer, once there is nothing left to do."""
    news_of(bench)
    return bench.answer


def cell_of_real_arms(folder, forearm):
    """The shipped cell of two UR5-class arms with the manufacturer's arms, but another mesh of the forearm."""
    text = (ROBOTS / "ur_description" / "urdf" / "ur5_robot.urdf").read_text()
    mesh = "package://example-robot-data/robots/ur_description/meshes/ur5/visual/forearm.dae"
    assert mesh in text
    text = text.replace(mesh, forearm)
    (folder / "arm.urdf").write_text(text.replace("package://example-robot-data", f"file://{ROBOTS.parent}"))
    cell = shipped("dual_ur5")
    return cell_file(folder, cell | {"robots": [robot | {"urdf": "arm.urdf"} for robot in cell["robots"]]})
