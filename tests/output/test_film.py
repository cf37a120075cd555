"""Films and pictures as files, read again."""

import os
import subprocess
import sys
from types import SimpleNamespace

import imageio_ffmpeg
import numpy as np
import pytest
from conftest import DATA, UR5
from PIL import Image
from shipped_cells import shipped

import mrts
from mrts.output import film
from mrts.output.film import KIND_COLOURS, Composition, write_film, write_picture
from mrts.plots.card import answer_card
from mrts.plots.trajectory_plots import limit_shares
from mrts.scene.cell_view import FIELD_OF_VIEW, look_at
from mrts.scene.renderer import Clip, SceneRenderer
from mrts.scene.scene import FORCE, OBJECT, OVER_LIMIT, PACES, arm_colour, blended, suited_pace

FEW = 2
"""Frames a second: enough to see what moves."""

ALIKE = 40
"""Of 255, how far a shaded colour's shares of red, green and blue may be off."""

SIZE = (200, 148)

HIDDEN = """
import ctypes, ctypes.util, sys
from mrts.cli import main
find, load = ctypes.util.find_library, ctypes.CDLL.__init__
def loaded(self, name, *given, **more):
    if name and ("EGL" in str(name) or "OSMesa" in str(name)):
        raise OSError(f"{name}: cannot open shared object file")
    load(self, name, *given, **more)
ctypes.util.find_library = lambda name: None if name in ("EGL", "OSMesa") else find(name)
ctypes.CDLL.__init__ = loaded
sys.exit(main(sys.argv[1:]))
"""
"""`mrts` on a machine without the libraries that draw."""


def clip_of(title, result):
    return Clip(title, result.trajectory, answer_card(result).deciding)


@pytest.fixture(scope="module")
def clips(planar_cell, lift, lifted):
    return [clip_of("as <given>", mrts.scale(planar_cell, lift, 0.5)), clip_of("fastest", lifted)]


def where(picture, colour):
    """Pixels of about a colour, however it is lit."""
    wanted = np.array(colour) / max(colour)
    largest = np.maximum(picture.max(axis=2, keepdims=True), 1)
    return np.all(np.abs(picture / largest - wanted) < ALIKE / 255, axis=2)


def amount(picture, colour):
    return np.mean(where(picture, colour))


def seen(camera, points):
    """Pixels of points, right and down, in a picture of `SIZE`."""
    along = (points - camera.position) @ camera.axes.T
    focal = SIZE[1] / 2 / np.tan(FIELD_OF_VIEW / 2)
    return np.array(SIZE) / 2 + focal * along[:, :2] / along[:, 2:] * [1, -1]


def rendered(clip, time):
    """A small picture of a moment, its camera, and the metres of arrow for a newton."""
    view = look_at(clip.scene)
    camera, scale = view.camera(SIZE[0] / SIZE[1]), 0.3 * view.size / clip.scene.strongest[0]
    drawn = SceneRenderer(clip, view, camera, SIZE, scale, pytest.fail)
    try:
        return drawn.picture(time).astype(float), camera, scale
    finally:
        drawn.close()


def test_a_film_shows_all_of_the_motion_and_says_how_slow(clips, tmp_path, monkeypatch):
    monkeypatch.setitem(film.RATES, ".gif", FEW)
    seen = []
    write_film(clips, tmp_path / "lift.gif", progress=lambda done, total: seen.append((done, total)))
    with Image.open(tmp_path / "lift.gif") as opened:
        frames, lasts = [], []
        for number in range(opened.n_frames):
            opened.seek(number)
            frames.append(np.asarray(opened.convert("RGB"), dtype=float))
            lasts.append(opened.info["duration"])
    longest = clips[0].trajectory.duration
    pace = suited_pace(longest)
    assert sum(lasts) / 1000 == pytest.approx(longest / pace + film.BEFORE + film.AFTER, abs=2 / FEW)
    assert seen[-1] == (len(seen) - 1, len(seen))
    first, last = frames[0], frames[-1]
    half = first.shape[1] // 2
    assert np.mean(np.abs(first - last) > 30) > 0.01
    waited = frames[int(clips[1].trajectory.duration / pace * FEW) + 2]  # the faster one has ended
    scene = slice(60, first.shape[0] - 160)
    assert np.mean(np.abs(waited[scene, half:] - last[scene, half:]) > 30) < 0.001
    assert np.mean(np.abs(waited[scene, :half] - last[scene, :half]) > 30) > 0.003


def test_an_mp4_has_the_same_frames(clips, tmp_path, monkeypatch):
    monkeypatch.setitem(film.RATES, ".mp4", FEW)
    path = tmp_path / "lift.mp4"
    write_film(clips[1:], path)
    read = [imageio_ffmpeg.get_ffmpeg_exe(), *f"-loglevel error -i {path} -f rawvideo -pix_fmt rgb24 -".split()]
    content = subprocess.run(read, capture_output=True, check=True).stdout
    width, height = Composition(clips[1:]).size
    frames = np.frombuffer(content, dtype=np.uint8).reshape(-1, height, width, 3)
    assert len(frames) >= 3 * FEW
    expected = Composition(clips[1:], PACES[0.1] + " of real time").frame(clips[1].trajectory.duration)
    assert np.mean(np.abs(frames[-1].astype(float) - expected)) < 6


def test_a_picture_has_arms_object_forces_and_lines_of_each_limit(clips, tmp_path):
    write_picture(clips, tmp_path / "moment.png", 0.1)
    with Image.open(tmp_path / "moment.png") as opened:
        picture = np.asarray(opened.convert("RGB"), dtype=float)
    for colour in (arm_colour(0), arm_colour(1), FORCE):
        assert amount(picture[50:-150], colour) > 0.001, colour
    plots = picture[-150:]
    for place, _ in enumerate(limit_shares(clips[1].trajectory)):
        colour = tuple(int(KIND_COLOURS[place][at : at + 2], 16) for at in (1, 3, 5))
        for part in (plots[:-30], plots[-30:]):  # its line, and its name
            assert np.mean(np.all(np.abs(part - colour) < ALIKE, axis=2)) > 0.0005
    assert {path.name for path in tmp_path.iterdir()} == {"moment.png"}


def test_arms_object_and_forces_are_where_the_motion_has_them(dual_ur5):
    """Colours at the pixels onto which joints, the object's middle and the forces' tips fall."""
    clip = clip_of("", mrts.scale(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml")))
    time = clip.trajectory.duration / 2
    picture, camera, scale = rendered(clip, time)
    scene, place = clip.scene, clip.scene.place(time)
    lines = [blended(line, place) for line in scene.lines]
    for number, line in enumerate(lines):
        elbow = seen(camera, (line[2:3] + line[3:4]) / 2)[0].astype(int)
        assert where(picture, arm_colour(number))[elbow[1] - 2 : elbow[1] + 3, elbow[0] - 2 : elbow[0] + 3].any()
    point, pull, _ = (blended(each, place) for each in scene.contacts)
    force = where(picture, FORCE)
    for share, is_seen in ((0.9, True), (1.2, False)):
        for right, down in seen(camera, point + share * scale * pull).astype(int):
            assert force[down - 1 : down + 2, right - 1 : right + 2].any() == is_seen, share
    assert amount(picture, OBJECT) > 0.03
    joint = seen(camera, lines[1][5:6])[0].astype(int)
    assert where(picture, OVER_LIMIT)[joint[1] - 3 : joint[1] + 4, joint[0] - 3 : joint[0] + 4].any()


def test_surroundings_are_where_the_cell_file_has_them(lift_and_turn):
    """A drum's pixels change at its middle, and what is behind it still shows through."""
    drum = {"name": "drum", "cylinder": {"radius": 0.05, "length": 0.1}, "pose": {"xyz": [0.0, 0.5, 0.6]}}
    pictures = []
    for around in ([], [drum]):
        cell = mrts.Cell.from_description(shipped("dual_ur5") | {"surroundings": around}, folder=UR5)
        picture, camera, _ = rendered(clip_of("", mrts.scale(cell, lift_and_turn)), 0.2)
        pictures.append(picture)
    changed = np.max(np.abs(pictures[1] - pictures[0]), axis=2)
    ((right, down),) = seen(camera, np.array([drum["pose"]["xyz"]]))
    assert 5 < changed[int(down), int(right)] < 150
    assert 0.001 < np.mean(changed > 5) < 0.1


@pytest.mark.quick
def test_what_cannot_be_a_film_is_told(clips, tmp_path):
    with pytest.raises(mrts.InputError, match="one to 4"):
        write_film(clips * 3, tmp_path / "lift.gif")
    long = SimpleNamespace(trajectory=SimpleNamespace(duration=1e5))
    with pytest.raises(mrts.InputError, match="at most 3600 frames"):
        write_film([long], tmp_path / "lift.gif")
    assert list(tmp_path.iterdir()) == []


def test_where_nothing_can_draw_what_to_install_is_told(tmp_path):
    """In a process whose libEGL and libOSMesa are not found: exit code 2, before any work."""
    moment = str(tmp_path / "x.png")
    command = [sys.executable, "-c", HIDDEN, "view", DATA / "cell.yaml", DATA / "lift.yaml", "--png", moment]
    environment = os.environ | {"MUJOCO_GL": "egl"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 2, done.stderr
    assert "libegl1" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
