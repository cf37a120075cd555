# SPDX-License-Identifier: MIT
"""A film of played motions as a file, and a picture of one moment."""

from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
from PIL import Image

from mrts.base.argument_types import Progress, require_extra
from mrts.base.atomic_file import write_atomically
from mrts.base.errors import InputError
from mrts.scene.arm_meshes import Warn
from mrts.scene.frames import Composition
from mrts.scene.renderer import Clip, Frame, silent
from mrts.scene.scene import PACES, suited_pace

RATES = {".gif": 20, ".mp4": 30}
"""Frames a second: of a GIF a whole number of hundredths, which it counts in."""

BEFORE, AFTER = 0.4, 1.2
"""What stands still before and after the motion [s]."""

SAMPLES = 6
"""Frames along a film in which the colours of a GIF are looked for."""

LONGEST = 3600
"""Frames of a film: three minutes of a GIF, and minutes to draw."""


def write_film(
    clips: Sequence[Clip],
    path: Path,
    warn: Warn = silent,
    progress: Progress = lambda _done, _total: None,
) -> None:
    """Write a film of motions side by side, whole or not at all.

    All start together; one that ends first stands and waits. The film is slowed down to last some seconds, and says so.

    Args:
        clips: One to four.
        path: The file, .gif or .mp4.
        warn: Told which arm is drawn without its meshes, and why.
        progress: Told how many frames are drawn.

    Raises:
        InputError: As `check_film`; if the film would be too long, or the file cannot be written.
    """
    check_film(path)
    ending = path.suffix.lower()
    rate, longest = RATES[ending], max(clip.trajectory.duration for clip in clips)
    pace = suited_pace(longest)
    frames = int(np.ceil(longest / pace * rate)) + 1
    if frames > LONGEST:
        rule = f"a film has at most {LONGEST} frames, this motion would take {frames}."
        raise InputError("--video", f"{rule} Cut the motion into parts.", value=str(path))
    times = np.minimum(np.arange(frames) * pace / rate, longest).tolist()
    shown = [times[0]] * round(BEFORE * rate) + times + [longest] * round(AFTER * rate)
    words = PACES[pace] if pace == 1 else f"{PACES[pace]} of real time"
    with closing(Composition(clips, words, warn)) as composition:

        def drawn() -> Iterator[Frame]:
            frame, last = composition.frame(times[0]), times[0]
            for number, time in enumerate(shown):
                progress(number, len(shown))
                frame, last = (frame if time == last else composition.frame(time)), time
                yield frame

        def write(temporary: Path) -> None:
            if ending == ".mp4":
                _write_mp4(temporary, drawn(), composition.size, rate)
            else:
                some = [composition.frame(times[number]) for number in np.linspace(0, frames - 1, SAMPLES).astype(int)]
                _write_gif(temporary, drawn(), np.concatenate(some), rate)

        write_atomically(path, write)


def write_picture(clips: Sequence[Clip], path: Path, time: float, warn: Warn = silent) -> None:
    """Write a PNG of motions side by side at one time, whole or not at all.

    Args:
        clips: One to four.
        path: The file.
        time: At the played speed [s].
        warn: As in `write_film`.

    Raises:
        InputError: If the file cannot be written, or there is nothing to draw it by.
    """
    with closing(Composition(clips, warn=warn)) as composition:
        picture = Image.fromarray(composition.frame(time))
    write_atomically(path, lambda temporary: picture.save(temporary, "PNG", optimize=True))


def check_film(path: Path) -> None:
    """Say before any work what would keep a film from being written.

    Raises:
        InputError: If its name ends otherwise than .gif or .mp4, or there is nothing to code an mp4 by.
    """
    if path.suffix.lower() not in RATES:
        raise InputError("--video", "writes a file that ends in .gif or .mp4.", value=str(path))
    if path.suffix.lower() == ".mp4":
        require_extra("--video", "film", "imageio_ffmpeg")


def _write_mp4(path: Path, frames: Iterator[Frame], size: tuple[int, int], rate: int) -> None:
    from imageio_ffmpeg import write_frames  # noqa: PLC0415 (not for a GIF)

    options = ["-crf", "20", "-f", "mp4", "-movflags", "+faststart"]
    coder = write_frames(
        path, size, fps=rate, codec="libx264", quality=None, macro_block_size=1, output_params=options,
        ffmpeg_log_level="error",
    )  # fmt: skip
    with closing(coder):
        coder.send(None)
        for frame in frames:
            coder.send(frame)


def _write_gif(path: Path, frames: Iterator[Frame], some: Frame, rate: int) -> None:
    """One palette for all frames, of some of them below each other, so that what stands still is stored once."""
    palette = Image.fromarray(some).quantize(255, dither=Image.Dither.NONE)
    images = (Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    next(images).save(path, "GIF", save_all=True, append_images=images, duration=1000 // rate, loop=0)
