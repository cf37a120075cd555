# SPDX-License-Identifier: MIT
"""The viewer of a saved result: the scene, the plots and the player, with nothing to change; needs the extra 'view'."""

from collections.abc import Callable

import viser

from mrts.viewer.motion_viewer import MotionViewer
from mrts.viewer.panel import note_html
from mrts.viewer.plots.other_result import Others
from mrts.viewer.plots.saved_state import SavedState
from mrts.viewer.workbench.answer import Answer
from mrts.viewer.workbench.choices import Choices

FIXED = "A saved result is played at the speed it was saved with. To change something, view its cell and motion."


class SavedViewer(MotionViewer):
    """The controls and the scene of a saved result.

    Args:
        server: Where.
        state: What.
        warn: As in `MotionViewer`.
        others: As there.
    """

    def __init__(
        self, server: viser.ViserServer, state: SavedState, warn: Callable[[str], None], others: Others = ()
    ) -> None:
        super().__init__(server, Answer(Choices(), state), {}, warn, others)
        server.gui.add_html(note_html(FIXED))
        self._add_player()
        self._add_texts()
        self._add_tabs()
        self._show_answer(self._answer)
