# SPDX-License-Identifier: MIT
"""Pictures and films of what is shown, for the browser that asks; needs the extras 'view' and 'film'."""

import re
import tempfile
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError
from mrts.scene.arm_meshes import Urdfs
from mrts.viewer.panel import error_html, note_html
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.other_result import Others
from mrts.viewer.workbench.answer import Answer

if TYPE_CHECKING:
    from mrts.film.renderer import Clip

PICTURE = "Picture (PNG)"
FORMATS = {PICTURE: ".png", "Film (GIF)": ".gif", "Film (mp4)": ".mp4"}
"""Endings of files, by what is on the button."""

NO_LETTER = re.compile(r"[^A-Za-z0-9_-]+")
"""What of a cell's name, which a saved result may hold as it likes, is not in the name of a file."""

LONGEST_NAME = 60
NEEDS = ("matplotlib", "mujoco", "PIL", "imageio_ffmpeg")


class _AskerLeftError(Exception):
    """The browser that asked for a file is gone."""


class FilmControls:
    """Buttons that make a file of the motion as it is shown, seen from where the browser looks.

    A film is drawn by a thread of its own, while everything else goes on, and no longer than its browser stays.
    """

    def __init__(self, server: viser.ViserServer, urdfs: Urdfs, others: Others = ()) -> None:
        gui, self._clients, self._urdfs = server.gui, server.get_clients, urdfs
        self._others = others
        self._state: PlayerState | None = None
        self._coarse = False
        self._worker: Thread | None = None
        self._asked: SimpleQueue[tuple[viser.ClientHandle, str]] = SimpleQueue()
        self._failed: Exception | None = None
        self._said = self._shown = ""
        with gui.add_folder("Pictures"):
            if lacking := [name for name in NEEDS if find_spec(name) is None]:
                gui.add_html(note_html(f"Pictures and films need {lacking[0]}: pip install 'mrts[film]'."))
            self._buttons = [gui.add_button(name, disabled=bool(lacking)) for name in FORMATS]
            self._text = gui.add_html("")
        for button in self._buttons:
            button.on_click(self._note)

    def show_answer(self, answer: Answer) -> None:
        """Take what is shown."""
        self._state, self._coarse = answer.state, answer.coarse

    def show_moment(self, state: PlayerState) -> None:
        """Take the moment."""
        self._state = state

    def step(self, elapsed: float) -> None:  # noqa: ARG002 (what every part is told)
        """Begin what was asked for, once the whole answer is there, and say how far it is."""
        with suppress(Empty):
            if not self._coarse:
                self._begin(*self._asked.get_nowait())
        if self._failed is not None:
            raise self._failed
        if self._said != self._shown:
            self._shown = self._said
            self._text.content = self._said

    def _note(self, event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        """Keep what a browser asks for, for the thread that follows the controls."""
        if event.client is not None:
            self._asked.put((event.client, event.target.label))

    def _begin(self, client: viser.ClientHandle, kind: str) -> None:
        state = self._state
        if self._worker is not None and self._worker.is_alive():
            return  # it says how far it is
        if state is None:
            self._said = error_html("There is no motion to show.")
            return
        from mrts.film.renderer import Clip  # noqa: PLC0415 (an extra of its own)

        clips = [Clip(f"c = {state.trajectory.c:.4g}", state.trajectory, state.result.range, self._urdfs)]
        clips += [Clip(name, each.trajectory, each.range) for name, each in self._others if each.trajectory is not None]
        backward = np.asarray(client.camera.position) - np.asarray(client.camera.look_at)
        work = (client, kind, clips, state.time, backward)
        self._worker = Thread(target=self._make, args=work, name="mrts film", daemon=True)
        self._worker.start()

    def _make(self, client: viser.ClientHandle, kind: str, clips: "list[Clip]", at: float, backward: Array) -> None:
        from mrts.film.film import picture_bytes, write_film  # noqa: PLC0415 (likewise)

        def require_asker() -> None:
            if client.client_id not in self._clients():
                raise _AskerLeftError

        def tell(drawn: int, frames: int) -> None:
            require_asker()
            self._said = note_html(f"Drawing frame {drawn + 1} of {frames} …")

        try:
            self._said = note_html("Drawing …")
            name = f"{NO_LETTER.sub('_', clips[0].scene.cell.name)[:LONGEST_NAME]}{FORMATS[kind]}"
            if kind == PICTURE:
                content = picture_bytes(clips, at, backward)
            else:
                with tempfile.TemporaryDirectory(prefix="mrts-film-") as folder:
                    write_film(clips, Path(folder) / name, backward, progress=tell)
                    content = (Path(folder) / name).read_bytes()
            require_asker()
            client.send_file_download(name, content, save_immediately=True)
            self._said = note_html(f"{name} has {len(content) / 1e6:.2f} MB.")
        except _AskerLeftError:
            self._said = note_html("The browser that asked for it is closed.")
        except MrtsError as error:
            self._said = error_html(str(error))
        except OSError as error:
            self._said = error_html(str(InputError(kind, f"cannot be written: {error.strerror}.")))
        except Exception as error:  # noqa: BLE001 (raised again where the controls are followed)
            self._failed = error
