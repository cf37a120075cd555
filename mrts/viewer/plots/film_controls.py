# SPDX-License-Identifier: MIT
"""Pictures and films of what is shown, for the browser that asks; needs the extras 'view' and 'film'."""

import tempfile
from importlib.util import find_spec
from pathlib import Path
from threading import Thread

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.base.errors import MrtsError
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.viewer.panel import error_html, note_html
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.other_result import Others
from mrts.viewer.scene_arms import Urdfs
from mrts.viewer.workbench.workbench import Answer

FORMATS = ("Picture (PNG)", "Film (GIF)", "Film (mp4)")
NEEDS = ("matplotlib", "PIL")


class FilmControls:
    """Buttons that make a file of the motion as it is shown, seen from where the browser looks.

    A film is drawn by a thread of its own, while everything else goes on.

    Args:
        gui: Where, in the container that is open.
        urdfs: As the scene has them.
        others: Results that stand beside it.
    """

    def __init__(self, gui: viser.GuiApi, urdfs: Urdfs, others: Others = ()) -> None:
        self._urdfs = urdfs
        self._others = [(name, done) for name, result in others if (done := result.trajectory) is not None]
        self._state: PlayerState | None = None
        self._worker: Thread | None = None
        self._said = self._shown = ""
        with gui.add_folder("Pictures"):
            if lacking := [name for name in NEEDS if find_spec(name) is None]:
                gui.add_html(note_html(f"Pictures and films need {lacking[0]}: pip install 'mrts[film]'."))
            self._buttons = [gui.add_button(name, disabled=bool(lacking)) for name in FORMATS]
            self._text = gui.add_html("")
        for button in self._buttons:
            button.on_click(self._ask)

    def show_answer(self, answer: Answer) -> None:
        """Take what is shown."""
        self._state = answer.state

    def show_moment(self, state: PlayerState) -> None:
        """Take the moment."""
        self._state = state

    def step(self, elapsed: float) -> None:  # noqa: ARG002 (what every part is told)
        """Say how far a film is."""
        if self._said != self._shown:
            self._shown = self._said
            self._text.content = self._said

    def _ask(self, event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        state, client = self._state, event.client
        if client is None or (self._worker is not None and self._worker.is_alive()):
            return
        if state is None:
            self._said = error_html("There is no motion to show.")
            return
        backward = np.asarray(client.camera.position) - np.asarray(client.camera.look_at)
        done, at, kind = state.trajectory, state.time, event.target.label
        work = (client, kind, done, at, backward)
        self._worker = Thread(target=self._make, args=work, name="mrts film", daemon=True)
        self._worker.start()

    def _make(self, client: viser.ClientHandle, kind: str, done: ScaledTrajectory, at: float, backward: Array) -> None:
        from mrts.film.film import picture_bytes, write_film  # noqa: PLC0415 (an extra of its own)
        from mrts.film.stage import Take  # noqa: PLC0415

        takes = [Take(f"c = {done.c:.4g}", done, self._urdfs), *(Take(name, other) for name, other in self._others)]

        def tell(drawn: int, frames: int) -> None:
            self._said = note_html(f"Drawing frame {drawn + 1} of {frames} …")

        try:
            self._said = note_html("Drawing …")
            if kind == FORMATS[0]:
                name, content = f"{done.cell.name}.png", picture_bytes(takes, at, backward)
            else:
                name = f"{done.cell.name}.{'gif' if kind == FORMATS[1] else 'mp4'}"
                with tempfile.TemporaryDirectory(prefix="mrts-film-") as folder:
                    write_film(takes, Path(folder) / name, backward, progress=tell)
                    content = (Path(folder) / name).read_bytes()
            client.send_file_download(name, content, save_immediately=True)
            self._said = note_html(f"{name} has {len(content) / 1e6:.2f} MB.")
        except MrtsError as error:
            self._said = error_html(str(error))
