"""Films and pictures as files, read again."""

import subprocess
import sys
import weakref
from types import SimpleNamespace

import imageio_ffmpeg
import numpy as np
import pytest
from conftest import DATA
from PIL import Image

import mrts
from mrts.cell.source_files import urdf_files
from mrts.film import film
from mrts.film.camera import framing_camera
from mrts.film.film import write_film, write_picture
from mrts.film.frames import KIND_COLOURS, Composition
from mrts.film.gif import write_gif
from mrts.film.lettering import fitting, font
from mrts.film.stage import ARMS, FORCE, Stage, Take
from mrts.plots.limit_plots import limit_shares

FEW = 2
"""Frames a second: enough to see what moves."""

ALIKE = 40
"""Of 255, how far a shaded colour's shares of red, green and blue may be off."""

WATCHED_AT_ONCE = 3
"""Frames: the one that is made, and what the writer and its caller still name."""


class Watched(np.ndarray):
    """A frame whose end can be seen."""

    __hash__ = object.__hash__


@pytest.fixture(scope="module")
def takes(planar_cell, lift, lifted):
    return [Take("as <given>", mrts.scale(planar_cell, lift, 0.5).trajectory), Take("fastest", lifted.trajectory)]


def amount(picture, colour):
    """Share of pixels of about a colour, however it is lit."""
    wanted = np.array(colour) / max(colour)
    largest = np.maximum(picture.max(axis=2, keepdims=True), 1)
    return np.mean(np.all(np.abs(picture / largest - wanted) < ALIKE / 255, axis=2))


def test_a_film_shows_all_of_the_motion_and_says_how_slow(takes, tmp_path, monkeypatch):
    monkeypatch.setattr(film, "RATE", FEW)
    seen = []
    write_film(takes, tmp_path / "lift.gif", progress=lambda done, total: seen.append((done, total)))
    with Image.open(tmp_path / "lift.gif") as opened:
        frames, lasts = [], []
        for number in range(opened.n_frames):
            opened.seek(number)
            frames.append(np.asarray(opened.convert("RGB"), dtype=float))
            lasts.append(opened.info["duration"])
    longest = takes[0].trajectory.duration
    pace = next(pace for pace in film.PACES if longest >= film.SHORTEST * pace)
    assert sum(lasts) / 1000 == pytest.approx(longest / pace + film.BEFORE + film.AFTER, abs=2 / FEW)
    assert seen[-1] == (len(seen) - 1, len(seen))
    first, last = frames[0], frames[-1]
    half = first.shape[1] // 2
    assert np.mean(np.abs(first - last) > 30) > 0.01
    waited = frames[int(takes[1].trajectory.duration / pace * FEW) + 2]  # the faster one has ended
    scene = slice(60, first.shape[0] - 160)
    assert np.mean(np.abs(waited[scene, half:] - last[scene, half:]) > 30) < 0.001
    assert np.mean(np.abs(waited[scene, :half] - last[scene, :half]) > 30) > 0.003


def test_an_mp4_has_the_same_frames(takes, tmp_path, monkeypatch):
    monkeypatch.setattr(film, "SMOOTH_RATE", FEW)
    path = tmp_path / "lift.mp4"
    write_film(takes[1:], path)
    read = [
        imageio_ffmpeg.get_ffmpeg_exe(),
        "-loglevel",
        "error",
        "-i",
        path,
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-",
    ]
    content = subprocess.run(read, capture_output=True, check=True).stdout
    width, height = Composition(takes[1:]).size
    frames = np.frombuffer(content, dtype=np.uint8).reshape(-1, height + height % 2, width + width % 2, 3)
    assert len(frames) >= 3 * FEW
    shown = frames[-1, :height, :width]
    expected = Composition(takes[1:], film.PACES[0.1]).frame(takes[1].trajectory.duration)
    assert np.mean(np.abs(shown.astype(float) - expected)) < 6


def test_a_picture_has_arms_object_forces_and_lines_of_each_limit(takes, tmp_path):
    write_picture(takes, tmp_path / "moment.png", 0.1)
    with Image.open(tmp_path / "moment.png") as opened:
        picture = np.asarray(opened.convert("RGB"), dtype=float)
    for colour in (*ARMS[:2], FORCE):
        assert amount(picture[50:-150], colour) > 0.001, colour
    plots = picture[-150:]
    for place, _ in enumerate(limit_shares(takes[1].trajectory)):
        colour = tuple(int(KIND_COLOURS[place][at : at + 2], 16) for at in (1, 3, 5))
        assert np.mean(np.all(np.abs(plots - colour) < ALIKE, axis=2)) > 0.0005
    assert {path.name for path in tmp_path.iterdir()} == {"moment.png"}


def test_takes_interpolate_and_stand_at_their_ends(lifted):
    take, done = Take("", lifted.trajectory), lifted.trajectory
    for sample in (0, 40, len(done.time) - 1):
        q, position, rotation, wrench = take.at(done.time[sample])
        np.testing.assert_allclose(q, done.q[sample], atol=1e-12)
        np.testing.assert_allclose(position, done.motion.object.position[sample], atol=1e-12)
        np.testing.assert_allclose(rotation, done.motion.object.rotation[sample], atol=1e-12)
        np.testing.assert_allclose(wrench, done.wrench[sample], atol=1e-9)
    np.testing.assert_array_equal(take.at(1e3)[0], take.at(done.duration)[0])


def test_an_arm_whose_meshes_lack_is_drawn_and_told(lifted, tmp_path):
    said = []
    Stage([Take("", lifted.trajectory, {"left": (tmp_path / "none.urdf", None)})], (80, 60), warn=said.append)
    assert len(said) == 1
    assert "robot 'left' is drawn with simple shapes" in said[0]


@pytest.mark.parametrize("shared", [True, False])
def test_what_two_arms_stand_on_has_the_colour_of_neither(shared, monkeypatch):
    folder, striking = DATA.parent / "upper_body", (255, 0, 255)
    monkeypatch.setattr("mrts.film.stage.SHARED_BASE", striking)
    if not shared:
        monkeypatch.setattr("mrts.film.stage.shares_base", lambda _cell, _robot: False)
    result = mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "lift.yaml"))
    take = Take("", result.trajectory, urdf_files(folder / "cell.yaml"))
    assert (amount(Stage([take], (160, 120)).picture(take, 0.0), striking) > 0) == shared


@pytest.mark.quick
def test_text_is_smaller_rather_than_cut_and_cut_only_at_last():
    assert fitting("short", 30, 500)[0] == "short"
    text, chosen = fitting("a title that is much too long for its place", 30, 300)
    assert text.endswith("its place")
    assert chosen.getlength(text) <= 300
    text, chosen = fitting("x" * 400, 30, 100)
    assert "…" in text
    assert chosen.getlength(text) <= 100
    missing = font(20).getmask("\uffff").getbbox()
    assert all(font(20).getmask(letter).getbbox() not in (None, missing) for letter in "c²⁺τ×…")


def test_what_cannot_be_a_film_is_told(takes, tmp_path, monkeypatch):
    for name in ("lift.avi", "lift"):
        with pytest.raises(mrts.InputError, match=r"\.gif or \.mp4"):
            write_film(takes, tmp_path / name)
    with pytest.raises(mrts.InputError, match="one to 4"):
        write_film(takes * 3, tmp_path / "lift.gif")
    long = SimpleNamespace(trajectory=SimpleNamespace(duration=1e5))
    with pytest.raises(mrts.InputError, match="at most 3600 frames"):
        write_film([long], tmp_path / "lift.gif")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(mrts.InputError, match=r"pip install 'mrts\[film\]'"):
        write_film(takes, tmp_path / "lift.mp4")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.quick
def test_a_camera_may_look_from_right_above_but_from_somewhere():
    points, size = np.random.default_rng(1).uniform(-1, 1, (50, 3)), (300, 200)
    for backward in ([0, 0, 1], [1e-9, 0, 2], [0, 0, -1], [0.005, 0, 1], [1, 0.2, 0.1]):
        seen = framing_camera(points, np.array(backward), np.array([0.0, 0.0, 1.0]), size).seen(points)
        assert np.all(seen[:, 2] > 0), backward
        assert np.all((seen[:, :2] > 0) & (seen[:, :2] < size)), backward
    for backward in ([0, 0, 0], [np.nan, 0, 1]):
        with pytest.raises(mrts.InputError, match="must have a direction"):
            framing_camera(points, np.array(backward), np.array([0.0, 0.0, 1.0]), size)


def test_a_gif_keeps_no_frame_but_the_last_and_shows_each_for_its_time(tmp_path):
    """However long a film is, it fits into memory: as many frames are alive with ten as with sixty."""
    alive, most = weakref.WeakSet(), []

    def frames(count):
        for number in range(count):
            frame = np.full((30, 40, 3), 255, dtype=np.uint8).view(Watched)
            frame[5:15, 2 + number // 2 % 8 : 12 + number // 2 % 8] = FORCE  # as before in every second one
            alive.add(frame)
            most.append(len(alive))
            yield frame, 40

    for count in (10, 60):
        most.clear()
        expected = [frame.copy() for frame, _ in frames(count)]
        most.clear()
        write_gif(tmp_path / "film.gif", frames(count), expected[:2])
        assert max(most) <= WATCHED_AT_ONCE
        with Image.open(tmp_path / "film.gif") as opened:
            lasts, shown = [], []
            for number in range(opened.n_frames):
                opened.seek(number)
                lasts.append(opened.info["duration"])
                shown.append(np.asarray(opened.convert("RGB")))
        assert lasts == [80] * (count // 2)
        for number, picture in enumerate(shown):
            np.testing.assert_array_equal(picture, expected[2 * number])
