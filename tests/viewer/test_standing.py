"""A cell that is looked at without a motion: gaps of arms that do not reach, and what is saved of it."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from casadi_cells import casadi_cell
from conftest import DATA

from mrts.base.rigid_transform import RigidTransform
from mrts.cell.loading import cell_to_compile
from mrts.cli import main
from mrts.scene.cell_shapes import body_poses
from mrts.viewer.panel import held_html
from mrts.viewer.server import close_server, open_server
from mrts.viewer.viewer import Viewer
from mrts.viewer.workbench.choices import Given
from mrts.viewer.workbench.held_poses import still_motion, tip_pose
from mrts.viewer.workbench.saved_choices import save_choices
from mrts.viewer.workbench.workbench import Workbench

HELD = 1e-6
"""Between a tip and its grasp [m]."""


@pytest.fixture
def alone(tmp_path, monkeypatch):
    """A cell that nothing was generated of."""
    monkeypatch.setenv("MRTS_CACHE_DIR", str(tmp_path / "cache"))
    path = shutil.copytree(DATA, tmp_path / "cell") / "cell.yaml"
    path.write_text(path.read_text().replace("mass: 0.5", "mass: 0.625"), encoding="utf-8")
    cell = cell_to_compile(path)
    assert cell is not None
    return Given(cell, still_motion(cell), cell_path=path, stands=True)


def test_a_cell_stands_at_its_posture_follows_its_places_and_is_saved(alone):
    server = open_server("127.0.0.1", 0, "test")
    try:
        bench = Workbench(alone)
        viewer = Viewer(server, bench, {}, pytest.fail)
        controls = {getattr(each, "label", ""): each for each in server.controls.values()}
        assert not any(controls[name].visible for name in ("speed c", "time [s]", "Play"))
        held = bench.answer.held
        assert held.reached.all()
        robot = held.cell.robots[0]
        R, p = body_poses(robot, robot.posture[None])
        np.testing.assert_allclose(held.q[0, :3], robot.posture, atol=HELD)
        np.testing.assert_allclose(held.position[0] + held.rotation[0] @ robot.T_object_tip.p,
                                   tip_pose(robot, R[0], p[0])[1], atol=HELD)  # fmt: skip
        far = RigidTransform(np.eye(3), robot.T_world_base.p - np.array([0.0, 3.0, 0.0]))
        bench.edit(bench.choices.with_base("left", far))
        viewer.settle()
        assert not bench.answer.held.reached[0, 0]
        assert held_html(bench.answer.held).count("mm") == 1
        assert len(server.scene.get_handle_by_name("/gaps").points) == 1
        near = RigidTransform(np.eye(3), robot.T_world_base.p + np.array([0.0, 0.02, 0.0]))
        bench.edit(replace(bench.choices.with_base("left", near), mass=0.75))
        viewer.settle()
        assert bench.answer.held.reached.all()
    finally:
        close_server(server)
    (path,), remark = save_choices(alone, bench.choices, "moved.yaml", "", overwrite=False)
    assert remark == ""
    saved = casadi_cell(path)
    np.testing.assert_allclose(saved.robots[0].T_world_base.p, near.p)
    assert saved.mass == 0.75


def test_the_command_shows_a_cell_alone(monkeypatch, capsys):
    """Ctrl-C comes at once."""
    monkeypatch.setattr(Viewer, "run", lambda _viewer: None)
    assert main(["view", str(DATA / "cell.yaml"), "--port", "0", "--no-open"]) == 0
    assert "no motion was given, the cell stands at its posture" in capsys.readouterr().out
