"""The viewer: arms where they are, all of them in the picture, and the real page in a real browser."""

import socket
from functools import partial

import numpy as np
import pytest
import viser
import yaml
import yourdfpy
from casadi_cells import casadi_cell
from cell_bank import random_planar_cell, random_spatial_cell
from command_line import mrts_without
from conftest import DATA, ROOT
from published_robots import ROBOTS
from scipy.spatial.transform import Rotation
from shown_results import as_if_generated
from viewer_browser import SIZE, chromium, in_picture, interrupt, open_page, running_viewer

import mrts
from mrts.cell.source_files import urdf_files
from mrts.cli import main
from mrts.scene.arm_meshes import arm_meshes, bars, drawn_arms
from mrts.scene.cell_shapes import body_poses, joint_points
from mrts.scene.cell_view import look_at_cell
from mrts.scene.scene import OVER_LIMIT, SHARED_BASE, arm_colour, deciding_limit
from mrts.viewer.scene import ViewerScene
from mrts.viewer.server import close_server, open_server
from mrts.viewer.viewer import Viewer
from mrts.viewer.workbench.choices import Given
from mrts.viewer.workbench.workbench import Workbench

assert chromium  # a fixture, imported for pytest

UR5 = DATA.parent / "dual_ur5"
UR5_URDF = ROBOTS / "ur_description" / "urdf" / "ur5_robot.urdf"
SINGLE = 2e-6
"""Of positions in a scene [m]: single precision of some metres."""

SAME_PLACE = 1e-9
"""[m]; meshes pass through single precision nowhere, but yourdfpy's angles are its own."""


def cell_of_real_arms(folder, urdf=UR5_URDF):
    """The shipped cell of two UR5-class arms, with the manufacturer's arms instead."""
    description = yaml.safe_load((UR5 / "cell.yaml").read_text())
    for robot in description["robots"]:
        robot["urdf"] = str(urdf)
    (folder / "cell.yaml").write_text(yaml.safe_dump(description), encoding="utf-8")
    return folder / "cell.yaml"


def arm_of(folder, urdf, base_link, tip_link, joints):
    """A cell of one arm of a URDF."""
    robot = {"name": "arm", "urdf": str(urdf), "base_link": base_link, "tip_link": tip_link}
    robot |= {"posture": [0.1] * joints, "torque": [100.0] * joints, "base": {"xyz": [1, 2, 3], "rpy": [0.3, 0.2, 0.1]}}
    cell = {"name": "arm", "gravity": [0, 0, -9.81], "object": {"mass": 1.0, "inertia": [0.01, 0.01, 0.01]}}
    (folder / "cell.yaml").write_text(yaml.safe_dump(cell | {"robots": [robot]}), encoding="utf-8")
    return folder / "cell.yaml"


@pytest.mark.parametrize(
    ("urdf", "base_link", "tip_link", "joints"),
    [
        ("ur_description/urdf/ur5_robot.urdf", None, "tool0", 6),
        ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp", 7),
        ("baxter_description/urdf/baxter.urdf", "torso", "left_gripper", 7),
        ("baxter_description/urdf/baxter.urdf", "left_upper_shoulder", "left_wrist", 6),
    ],
)
def test_meshes_stand_where_yourdfpy_puts_them(urdf, base_link, tip_link, joints, tmp_path):
    """The independent side is yourdfpy's kinematics at q; ours turns the meshes at zero by the manifest's axes."""
    cell = casadi_cell(arm_of(tmp_path, ROBOTS / urdf, base_link, tip_link, joints))
    (robot,) = cell.robots
    (path, base), *_ = urdf_files(tmp_path / "cell.yaml").values()
    assert base == base_link
    found = arm_meshes(path, base, robot.joints)
    assert {body for body, _ in found} >= set(range(1, joints - 1))
    handler = partial(yourdfpy.filename_handler_magic, dir=str(path.parent))
    model = yourdfpy.URDF.load(str(path), filename_handler=handler)
    q = np.random.default_rng(3).uniform(-1, 1, joints)
    model.update_cfg(dict(zip(robot.joints, q, strict=True)))
    first = base or model.base_link
    ours = []
    R, p = body_poses(robot, q[None])
    for body, mesh in found:
        ours.append(mesh.vertices[0] @ R[0, body].T + p[0, body])
    theirs = []
    for node in model.scene.graph.nodes_geometry:
        pose, name = model.scene.graph.get(node, first)
        vertex = model.scene.geometry[name].vertices[0] @ pose[:3, :3].T + pose[:3, 3]
        theirs.append(vertex @ robot.T_world_base.R.T + robot.T_world_base.p)
    for vertex in ours:
        assert np.min(np.linalg.norm(np.array(theirs) - vertex, axis=1)) < SAME_PLACE
    tip = model.get_transform(tip_link, first)[:3, 3]
    line = joint_points(robot, q[None])[0]
    np.testing.assert_allclose(line[-1], robot.T_world_base.R @ tip + robot.T_world_base.p, atol=SAME_PLACE)


def test_one_arm_of_two_does_not_draw_the_other():
    joints = tuple(f"left_{joint}" for joint in ("s0", "s1", "e0", "e1", "w0", "w1", "w2"))
    found = arm_meshes(ROBOTS / "baxter_description/urdf/baxter.urdf", "torso", joints)
    assert {body for body, _ in found} == set(range(8))
    vertices = np.concatenate([mesh.vertices for _, mesh in found])
    assert np.max(vertices[:, 1]) > 0.8
    assert np.min(vertices[:, 1]) > -0.6  # the right arm would reach as far to the other side


def test_a_joint_that_is_held_is_drawn_where_it_stands():
    """The right arm hangs on Baxter's torso; held bent, its meshes stand with the base, not left out or at zero."""
    path = ROBOTS / "baxter_description/urdf/baxter.urdf"
    joints = tuple(f"left_{joint}" for joint in ("s0", "s1", "e0", "e1", "w0", "w1", "w2"))
    held = {"left_s0": 0.7, "right_s0": 0.4, "right_s1": -0.3}
    found = arm_meshes(path, "torso", joints[1:], held)
    handler = partial(yourdfpy.filename_handler_magic, dir=str(path.parent))
    model = yourdfpy.URDF.load(str(path), filename_handler=handler)
    model.update_cfg(held)
    theirs = []
    for node in model.scene.graph.nodes_geometry:
        pose, name = model.scene.graph.get(node, "torso")
        theirs.append(model.scene.geometry[name].vertices[0] @ pose[:3, :3].T + pose[:3, 3])
    assert min(mesh.vertices[0][1] for _, mesh in found) < -0.3  # the right upper arm
    for _, mesh in found:
        assert np.min(np.linalg.norm(np.array(theirs) - mesh.vertices[0], axis=1)) < SAME_PLACE


@pytest.mark.parametrize("shared", [True, False])
def test_what_two_arms_stand_on_has_the_colour_of_neither(shared, monkeypatch):
    path = DATA.parent / "upper_body" / "cell.yaml"
    if not shared:
        monkeypatch.setattr("mrts.scene.arm_meshes.shares_base", lambda _cell, _robot: False)
    for index, parts in enumerate(drawn_arms(mrts.load_cell(path), urdf_files(path), pytest.fail)):
        base = {part.colour() for part in parts if part.body == 0}
        assert base == {SHARED_BASE if shared else arm_colour(index)}
        assert {part.colour() for part in parts if part.body} == {arm_colour(index)}


def test_the_joint_that_decides_stands_out(dual_ur5):
    """The range of this cell ends where the right arm's fifth joint reaches its velocity limit."""
    result = mrts.scale(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    found = deciding_limit(result.trajectory, result.range)
    (row,) = result.range.upper.rows
    assert found.name == row.name
    assert found.sample == result.range.upper.sample
    assert found.share == pytest.approx(1.0)
    slow = mrts.scale(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"), 1.0)
    assert deciding_limit(slow.trajectory, slow.range).share == pytest.approx(result.trajectory.c2**-0.5)
    left, right = drawn_arms(dual_ur5, {}, pytest.fail)
    assert [found.body(robot) for robot in dual_ur5.robots] == [None, 5]
    assert {part.body for part in right if part.colour(5) == OVER_LIMIT} == {5}
    assert all(part.colour(None) != OVER_LIMIT for part in (*left, *right))


@pytest.mark.parametrize("spoil", ["gone", "broken", "http"])
def test_an_arm_without_its_meshes_is_drawn_simply(spoil, tmp_path):
    text = UR5_URDF.read_text()
    mesh = "package://example-robot-data/robots/ur_description/meshes/ur5/visual/forearm.dae"
    assert mesh in text
    other = {"gone": "package://nowhere/forearm.dae", "broken": "broken.dae", "http": "http://127.0.0.1:9/x.dae"}[spoil]
    (tmp_path / "broken.dae").write_text("<not a mesh")
    text = text.replace(mesh, other).replace("package://example-robot-data", f"file://{ROBOTS.parent}")
    (tmp_path / "arm.urdf").write_text(text)
    path = cell_of_real_arms(tmp_path, tmp_path / "arm.urdf")
    bench = Workbench(Given(mrts.load_cell(path), mrts.load_motion(UR5 / "lift_and_turn.yaml")))
    warnings = []
    server = open_server("127.0.0.1", 0, "test")
    try:
        Viewer(server, bench, urdf_files(path), warnings.append).step(0.0)
        drawn = [server.scene.get_handle_by_name(f"/arms/{name}/body6/mesh1") for name in ("left", "right")]
    finally:
        close_server(server)
    assert all(handle is not None for handle in drawn)
    assert len(warnings) == 2
    assert all("is drawn with simple shapes" in warning and "arm.urdf" in warning for warning in warnings)
    assert spoil == "broken" or other in warnings[0]


def assert_links_join(scene, robot, line):
    """The middle of each bar, as the page moves it, is between neighbours of a line, unless the next joint slides."""
    seen = 0
    for number, part in enumerate(bars(robot, (1, 2, 3))):
        slides = (*robot.joint_types, "tip")[part.body] == "prismatic"
        if part.marks or slides:
            continue
        frame = scene.get_handle_by_name(f"/arms/{robot.name}/body{part.body}")
        mesh = scene.get_handle_by_name(f"/arms/{robot.name}/body{part.body}/mesh{number}")
        middle = Rotation.from_quat(np.roll(frame.wxyz, -1)).apply(np.mean(mesh.vertices, axis=0)) + frame.position
        between = line[part.body : part.body + 2]
        is_ball = number == 0
        np.testing.assert_allclose(middle, between[0] if is_ball else np.mean(between, axis=0), atol=SINGLE)
        seen += not is_ball
    assert seen > 0


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("arms", [1, 3])
def test_what_is_drawn_follows_the_time(make, arms, tmp_path):
    """Balls at the tips, and arrows that start there, at the contacts of the moving object; sliding joints too."""
    case = make(np.random.default_rng([11, arms]), tmp_path, arms)
    answer = Workbench(Given(case.cell, case.motion)).answer
    state = answer.state
    moved = state.result.motion.object
    server = open_server("127.0.0.1", 0, "test")
    try:
        scene = ViewerScene(server, answer, {}, pytest.fail)
        scene.rescale(state)
        for sample in (0, 4, 10):
            state.choose_time(float(state.trajectory.time[sample]))
            scene.show_moment(state, state.sample)
            arrows = server.scene.get_handle_by_name("/carried/forces").points
            arrows = moved.position[sample] + arrows @ moved.rotation[sample].T
            contacts = []
            for robot in state.result.cell.robots:
                contacts.append(moved.position[sample] + moved.rotation[sample] @ robot.T_object_tip.p)
                joints = state.result.cell.joint_slices[robot.name]
                line = joint_points(robot, state.result.motion.q[sample : sample + 1, joints])[0]
                np.testing.assert_allclose(line[-1], contacts[-1], atol=1e-6)
                assert_links_join(server.scene, robot, line)
            assert all(np.min(np.linalg.norm(contacts - start, axis=1)) < 1e-6 for start in arrows[:, 0])
            box = server.scene.get_handle_by_name("/object")
            np.testing.assert_allclose(box.position, moved.position[sample])
            turned = Rotation.from_quat(np.roll(box.wxyz, -1)).as_matrix()
            np.testing.assert_allclose(turned, moved.rotation[sample], atol=1e-12)
    finally:
        close_server(server)


def test_arrows_have_the_length_that_the_panel_states(dual_ur5):
    answer = Workbench(Given(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))).answer
    state = answer.state
    server = open_server("127.0.0.1", 0, "test")
    try:
        scene = ViewerScene(server, answer, {}, pytest.fail)
        scene.rescale(state)
        state.choose_time(0.5 * state.trajectory.duration)
        scene.show_moment(state, state.sample)
        arrows = {name: server.scene.get_handle_by_name(f"/carried/{name}").points for name in ("forces", "moments")}
    finally:
        close_server(server)
    wrench = state.trajectory.wrench[state.sample].reshape(2, 6)
    kinds = (
        ("forces", wrench[:, :3], scene.metres_per_newton),
        ("moments", wrench[:, 3:], scene.metres_per_newton_metre),
    )
    for name, values, scale in kinds:
        lengths = np.linalg.norm(arrows[name][:, 1] - arrows[name][:, 0], axis=1)
        np.testing.assert_allclose(lengths, np.linalg.norm(values, axis=1) * scale, rtol=1e-5)
        assert scale == float(f"{scale:.0e}")  # one digit


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("arms", [1, 3])
def test_the_cell_is_in_the_picture_and_upright(make, arms, tmp_path):
    case = make(np.random.default_rng([9, arms]), tmp_path, arms)
    cell = case.cell
    motion = mrts.follow_object(cell, case.motion)
    view = look_at_cell(cell, motion.q, motion.object.position)
    np.testing.assert_allclose(view.up, -cell.gravity / np.linalg.norm(cell.gravity))
    lines = [joint_points(robot, motion.q[:, cell.joint_slices[robot.name]]) for robot in cell.robots]
    points = np.concatenate([line.reshape(-1, 3) for line in lines])
    for aspect in (SIZE["width"] / SIZE["height"], 0.5, 3.0):
        across, high = in_picture(view, points, aspect)
        assert np.max(np.abs(high)) < 1
        assert np.max(np.abs(across)) < 1
    bases = np.array([robot.T_world_base.p for robot in cell.robots])
    assert np.min((bases - view.floor) @ view.up) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("plane", "up"), [("xy", [0, 1, 0]), ("xz", [0, 0, 1]), (None, [0, 0, 1])])
def test_without_gravity_something_is_up(plane, up, planar_cell, lift):
    cell, motion = as_if_generated(planar_cell, gravity=[0.0] * 3, plane=plane), mrts.follow_object(planar_cell, lift)
    np.testing.assert_array_equal(look_at_cell(cell, motion.q, motion.object.position).up, up)


def test_a_port_that_is_taken_is_refused():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(mrts.InputError, match=f"--port = {port}.*in use.*any free one"):
            open_server("127.0.0.1", port, "test")


@pytest.mark.parametrize(
    ("host", "port", "match"),
    [
        ("no.such.host.invalid", 0, "not a name or address"),
        ("203.0.113.1", 0, "--host = .*cannot be listened at"),
        ("127.0.0.1", 70000, "65535"),
    ],
)
def test_a_wrong_address_is_refused(host, port, match):
    with pytest.raises(mrts.InputError, match=match):
        open_server(host, port, "test")


@pytest.mark.quick
def test_bad_input_ends_before_any_server(tmp_path, capsys):
    assert main(["view", str(tmp_path / "no.yaml"), str(DATA / "lift.yaml")]) == 2
    assert "no.yaml" in capsys.readouterr().err


def test_a_missing_viser_is_named_before_any_work():
    done = mrts_without("viser", "view", "no.yaml", "no.yaml")
    assert done.returncode == 2
    assert "pip install 'mrts[view]'" in done.stderr


def numbers(page, kind):
    return page.locator(f'[data-text="{kind}"]').inner_text()


OVER = '[data-over="true"]:not([data-bar^=nearest])'
"""Bars of this moment that pass their limit; the card's are of the whole motion."""


def red(page):
    return page.locator(OVER).evaluate_all("rows => rows.map(row => row.dataset.bar)")


@pytest.mark.quick
def test_the_page_follows_the_speed_slider(chromium):
    """The planar lift binds at its first sample, so there the bars turn red as soon as c passes c⁺."""
    with running_viewer(DATA / "cell.yaml", DATA / "lift.yaml") as (process, url), open_page(chromium, url) as page:
        page.wait_for_selector("canvas")
        assert "[0, 3.062]" in numbers(page, "outcome")
        assert "c² = 3.062" in numbers(page, "speed")
        assert red(page) == []
        before = page.locator('[data-bar="torque left/shoulder"]').inner_text()
        speed, time = page.get_by_role("slider").all()
        speed.press("Home")
        page.wait_for_function("document.querySelector('[data-text=speed]').innerText.includes('c = 0.0')")
        assert page.locator('[data-bar="torque left/shoulder"]').inner_text() != before
        assert "Inside" in numbers(page, "speed")
        speed.press("End")
        page.wait_for_selector(OVER)
        assert {"torque left/elbow", "torque right/elbow", "wrench left/fx", "wrench right/nz"} <= set(red(page))
        assert "Outside the admissible range" in numbers(page, "speed")
        time.press("End")
        page.wait_for_selector(OVER, state="detached")
        assert "given motion: 0.5236 s" in numbers(page, "moment")
        assert page.problems == []
        out, err, code = interrupt(process)  # while the page is open
    assert code == 0
    assert err == ""
    assert len(out.splitlines()) == 2  # the outcome and the address: no banner


CONNECTS = """([url, protocol]) => new Promise(done => {
    const socket = new WebSocket(url, [protocol]);
    socket.onopen = () => done(true);
    socket.onerror = () => done(false);
})"""


@pytest.mark.slow
def test_the_page_can_be_loaded_again_and_no_other_page_connects(chromium):
    with running_viewer(DATA / "cell.yaml", DATA / "lift.yaml") as (_, url):
        ours = [url.replace("http", "ws"), f"viser-v{viser.__version__}"]
        with open_page(chromium, url) as page:
            page.reload()
            page.wait_for_selector("[data-bar]")
            assert page.problems == []
            assert page.evaluate(CONNECTS, ours)
        other = chromium.new_page()
        other.goto("about:blank")
        assert not other.evaluate(CONNECTS, ours)
        without_token = other.goto(url[: url.rindex("/", 0, -1) + 1])
        assert without_token.status == 403
        other.close()


@pytest.mark.slow
def test_the_motion_plays_and_stops(chromium):
    with (
        running_viewer(ROOT / "generated" / "dual_ur5", UR5 / "lift_and_turn.yaml") as (_, url),
        open_page(chromium, url) as page,
    ):
        assert len(page.locator("[data-bar]").all()) >= 24
        page.get_by_role("button", name="Play").click()
        start = numbers(page, "moment")
        page.wait_for_function("text => document.querySelector('[data-text=moment]').innerText != text", arg=start)
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play").wait_for()
        held = numbers(page, "moment")
        page.wait_for_timeout(300)
        assert numbers(page, "moment") == held
        assert page.problems == []


@pytest.mark.slow
def test_an_infeasible_motion_opens_with_real_arms(chromium, tmp_path):
    path = cell_of_real_arms(tmp_path)
    description = yaml.safe_load(path.read_text())
    description["object"]["mass"] = 80.0
    path.write_text(yaml.safe_dump(description))
    with running_viewer(path, UR5 / "lift_and_turn.yaml") as (process, url):
        with open_page(chromium, url) as page:
            assert "these limits conflict" in numbers(page, "outcome")
            assert "c = 1, c² = 1" in numbers(page, "speed")
            assert red(page)
            assert page.problems == []
        _, err, code = interrupt(process)
    assert code == 1
    assert err == ""
