# SPDX-License-Identifier: MIT
"""Pictures and films of what is shown, for the browser that asks; needs the extras 'view' and 'film'."""

import re
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError
from mrts.scaling.result import ScalingResult
from mrts.scene.arm_meshes import Urdfs
from mrts.viewer.controls import Later
from mrts.viewer.panel import text_html
from mrts.viewer.workbench import Answer

if TYPE_CHECKING:
    from mrts.scene.renderer import Clip

PICTURE = "Picture (PNG)"
FORMATS = {PICTURE: ".png", "Film (GIF)": ".gif", "Film (mp4)": ".mp4"}
"""Endings of files, by what is on the button."""

NO_LETTER = re.compile(r"[^A-Za-z0-9_-]+")
"""What of a cell's name, which a saved result may hold as it likes, is not in the name of a file."""

LONGEST_NAME = 60
NEEDS = ("matplotlib", "mujoco", "PIL", "imageio_ffmpeg")

Others = Sequence[tuple[str, ScalingResult]]
"""Results with a trajectory, each with its name for people."""


class FilmControls:
    """Buttons that make a file of the motion as it is shown, seen from where the browser looks.

    A film is drawn by a thread of its own, while everything else goes on, and no longer than its browser stays.

    Attributes:
        job: The last film or picture; None before the first.
    """

    def __init__(self, server: viser.ViserServer, urdfs: Urdfs, others: Others, later: Later) -> None:
        gui, self._urdfs, self._others = server.gui, urdfs, others
        self._clients: Callable[[], dict[int, viser.ClientHandle]] = server.get_clients
        self.job: Future[None] | None = None
        self._worker = ThreadPoolExecutor(1, "mrts film")
        self._asked: tuple[viser.ClientHandle, str] | None = None
        self._said = ""
        with gui.add_folder("Pictures"):
            if lacking := [name for name in NEEDS if find_spec(name) is None]:
                gui.add_html(text_html("note", f"Pictures and films need {lacking[0]}: pip install 'mrts[film]'."))
            for name in FORMATS:
                button = gui.add_button(name, disabled=bool(lacking))
                button.on_click(lambda event: later(lambda: self._ask(event.client, event.target.label)))
            self._text = gui.add_html("")

    def _ask(self, client: viser.ClientHandle | None, kind: str) -> None:
        if client is not None and (self.job is None or self.job.done()):  # else it says how far it is
            self._asked = client, kind

    def step(self, answer: Answer) -> None:
        """Begin what was asked for, once the whole answer is there, and say how far it is."""
        if self.job is not None and self.job.done():
            self.job.result()  # raises what a defect raised
        if self._asked is not None and not answer.coarse:
            (client, kind), self._asked, state = self._asked, None, answer.state
            if state is None:
                self._said = text_html("error", "There is no motion to show.")
            else:
                from mrts.scene.renderer import Clip  # noqa: PLC0415 (an extra of its own)

                clips = [Clip(f"c = {state.trajectory.c:.4g}", state.trajectory, state.result.range, self._urdfs)]
                clips += [Clip(name, of.trajectory, of.range) for name, of in self._others if of.trajectory is not None]
                backward = np.asarray(client.camera.position) - np.asarray(client.camera.look_at)
                self.job = self._worker.submit(self._make, client, kind, clips, state.time, backward)
        if self._said != self._text.content:
            self._text.content = self._said

    def close(self) -> None:
        """Send nothing more; what is being drawn ends with its frame."""
        self._clients = dict
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _make(self, client: viser.ClientHandle, kind: str, clips: "list[Clip]", at: float, backward: Array) -> None:
        from mrts.scene.film import picture_bytes, write_film  # noqa: PLC0415 (likewise)

        def require_asker() -> None:
            if client.client_id not in self._clients():
                raise InputError(kind, "the browser that asked for it is closed.")

        def tell(drawn: int, frames: int) -> None:
            require_asker()
            self._said = text_html("note", f"Drawing frame {drawn + 1} of {frames} …")

        try:
            self._said = text_html("note", "Drawing …")
            name = f"{NO_LETTER.sub('_', clips[0].scene.cell.name)[:LONGEST_NAME]}{FORMATS[kind]}"
            if kind == PICTURE:
                content = picture_bytes(clips, at, backward)
            else:
                with tempfile.TemporaryDirectory(prefix="mrts-film-") as folder:
                    write_film(clips, Path(folder) / name, backward, progress=tell)
                    content = (Path(folder) / name).read_bytes()
            require_asker()
            client.send_file_download(name, content, save_immediately=True)
            self._said = text_html("note", f"{name} has {len(content) / 1e6:.2f} MB.")
        except (MrtsError, OSError) as error:
            self._said = text_html("error", str(error))
