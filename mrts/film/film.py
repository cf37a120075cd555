# SPDX-License-Identifier: MIT
"""A film of played motions as a file, and a picture of one moment."""

import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.atomic_file import write_atomically
from mrts.base.errors import InputError
from mrts.base.printable import message_text
from mrts.film.frames import Composition, Frame
from mrts.film.gif import write_gif
from mrts.film.stage import Take, Warn, silent

RATE = 20
"""Frames a second: a whole number of hundredths, which a GIF counts in."""

SMOOTH_RATE = 30
"""Of an mp4."""

SHORTEST = 3.0
"""A film plays at least this long, at one of `PACES` [s]."""

PACES = {1.0: "real time", 0.5: "1/2 of real time", 0.2: "1/5 of real time", 0.1: "1/10 of real time",
         0.05: "1/20 of real time", 0.02: "1/50 of real time"}  # fmt: skip
"""Seconds of the motion in one of the film."""

BEFORE, AFTER = 0.4, 1.2
"""What stands still before and after the motion [s]."""

SAMPLES = 6
"""Frames along a film in which the colours of a GIF are looked for."""

LONGEST = 3600
"""Frames of a film: three minutes of a GIF, and minutes to draw."""


def write_film(
    takes: Sequence[Take],
    path: Path,
    backward: Array | None = None,
    warn: Warn = silent,
    progress: Progress = lambda _done, _total: None,
) -> None:
    """Write a film of motions side by side, whole or not at all.

    All start together; one that ends first stands and waits. The film is slowed down to last some seconds, and says so.

    Args:
        takes: One to four.
        path: The file, .gif or .mp4.
        backward: From the cell to the camera, world axes, Shape (3,); None looks from the front.
        warn: Told which arm is drawn without its meshes, and why.
        progress: Told how many frames are drawn.

    Raises:
        InputError: If the name ends otherwise, the film would be too long, the file cannot be written, or mp4 is asked
            for without imageio-ffmpeg.
    """
    write = _writers(path)
    rate = RATE if path.suffix.lower() == ".gif" else SMOOTH_RATE
    longest = max(take.trajectory.duration for take in takes)
    pace = next((pace for pace in PACES if longest >= SHORTEST * pace), min(PACES))
    frames = int(np.ceil(longest / pace * rate)) + 1
    if frames > LONGEST:
        rule = f"a film has at most {LONGEST} frames, this motion would take {frames}."
        raise InputError("--video", f"{rule} Cut the motion into parts.", value=str(path))
    composition = Composition(takes, PACES[pace], backward, warn)
    times = np.minimum(np.arange(frames) * pace / rate, longest)
    reel = _Reel(composition, times, rate, progress)
    write_atomically(path, lambda temporary: write(temporary, reel))


class _Reel:
    """The frames of a film, each drawn when it is asked for.

    Args:
        composition: What draws them.
        times: Of the motion, one a frame [s].
        rate: Frames a second.
        progress: Told how many frames are drawn.

    Attributes:
        size: Width and height [pixels].
        rate: As given.
    """

    def __init__(self, composition: Composition, times: Array, rate: int, progress: Progress) -> None:
        self.size, self.rate = composition.size, rate
        self._composition, self._times, self._progress = composition, times, progress
        self._kept: dict[int, Frame] = {}

    def frames(self) -> Iterator[tuple[Frame, float]]:
        """All, with how long each stands [s]."""
        last = len(self._times) - 1
        for number in range(last + 1):
            self._progress(number, last + 1)
            stands = 1 / self.rate + BEFORE * (number == 0) + AFTER * (number == last)
            yield (self._kept.pop(number) if number in self._kept else self._drawn(number)), stands

    def some(self) -> list[Frame]:
        """A few along the film, which are not drawn again."""
        for number in np.unique(np.linspace(0, len(self._times) - 1, SAMPLES).astype(int)).tolist():
            self._kept[number] = self._drawn(number)
        return list(self._kept.values())

    def _drawn(self, number: int) -> Frame:
        return self._composition.frame(float(self._times[number]))


def write_picture(
    takes: Sequence[Take],
    path: Path,
    time: float,
    backward: Array | None = None,
    warn: Warn = silent,
) -> None:
    """Write a PNG of motions side by side at one time, whole or not at all.

    Args:
        takes: One to four.
        path: The file.
        time: At the played speed [s].
        backward: As in `write_film`.
        warn: Likewise.

    Raises:
        InputError: If the file cannot be written.
    """
    content = picture_bytes(takes, time, backward, warn)
    write_atomically(path, lambda temporary: temporary.write_bytes(content))


def picture_bytes(takes: Sequence[Take], time: float, backward: Array | None = None, warn: Warn = silent) -> bytes:
    """What `write_picture` writes.

    Args:
        takes: As there.
        time: As there.
        backward: As there.
        warn: As there.
    """
    file = BytesIO()
    frame = Composition(takes, backward=backward, warn=warn).frame(time)
    Image.fromarray(frame).save(file, "PNG", optimize=True)
    return file.getvalue()


def check_film(path: Path) -> None:
    """Say before any work what would keep a film from being written.

    Args:
        path: The file.

    Raises:
        InputError: As `write_film`.
    """
    _writers(path)


Writer = Callable[[Path, _Reel], None]


def _writers(path: Path) -> Writer:
    suffix = path.suffix.lower()
    if suffix == ".gif":
        return _write_gif
    if suffix == ".mp4":
        _ffmpeg()
        return _write_mp4
    raise InputError("--video", "writes a file that ends in .gif or .mp4.", value=str(path))


def _write_gif(path: Path, reel: _Reel) -> None:
    some = reel.some()
    write_gif(path, ((frame, round(1000 * stands)) for frame, stands in reel.frames()), some)


def _write_mp4(path: Path, reel: _Reel) -> None:
    (width, height), rate = reel.size, reel.rate
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(rate), "-i", "pipe:"]
    coded = ["-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]
    target = ["-f", "mp4", "-movflags", "+faststart", "-y", f"file:{path}"]
    command = [_ffmpeg(), "-nostdin", "-loglevel", "error", *source, *coded, *target]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as coder:  # noqa: S603 (our words)
        assert coder.stdin is not None  # noqa: S101 (asked for)
        with suppress(BrokenPipeError):  # it says why it ended
            for frame, stands in reel.frames():
                shown = np.ascontiguousarray(frame).tobytes()
                for _ in range(round(stands * rate)):
                    coder.stdin.write(shown)
        _, said = coder.communicate()
    if coder.returncode != 0:
        raise InputError(path, f"cannot be made: {message_text(said.decode(errors='replace'))}")


def _ffmpeg() -> str:
    """The program that codes an mp4.

    Raises:
        InputError: If it is not installed.
    """
    try:
        import imageio_ffmpeg  # noqa: PLC0415 (an extra)
    except ImportError:
        rule = "an mp4 needs imageio-ffmpeg: pip install 'mrts[film]'; a name that ends in .gif needs nothing more."
        raise InputError("--video", rule) from None
    return str(imageio_ffmpeg.get_ffmpeg_exe())
