# SPDX-License-Identifier: MIT
"""Saving the cell and the motion as they were chosen; needs the extra 'view'."""

from collections.abc import Callable

import viser

from mrts.base.errors import MrtsError
from mrts.viewer.controls.bound_control import assign
from mrts.viewer.panel import error_html, note_html, saved_html
from mrts.viewer.workbench.saved_choices import save_choices, saving_folder
from mrts.viewer.workbench.workbench import Workbench

FIXED = "Only a cell file is written anew: this cell is from generated files, or a variant of a study."


class SaveControls:
    """Names of the files, and the button that writes them.

    Args:
        gui: Where, in the container that is open.
        bench: Whose choices are saved.
        later: Takes work for the thread that follows the controls.
    """

    def __init__(self, gui: viser.GuiApi, bench: Workbench, later: Callable[[Callable[[], None]], None]) -> None:
        self._bench = bench
        folder = saving_folder(bench.given)
        with gui.add_folder("Save as"):
            if folder is None:
                gui.add_html(note_html(FIXED))
                return
            gui.add_html(note_html(f"Into {folder}"))
            self._cell = gui.add_text("cell file", "changed_cell.yaml")
            described = bench.given.description is not None
            self._motion = gui.add_text("motion file", "changed_motion.yaml" if described else "", visible=described)
            self._replace = gui.add_checkbox("replace files", initial_value=False)
            save = gui.add_button("Save")
            self._said = gui.add_html("")
        save.on_click(lambda _: later(self._save))

    def _save(self) -> None:
        bench = self._bench
        try:
            paths, remark = save_choices(
                bench.given, bench.choices, self._cell.value, self._motion.value, overwrite=self._replace.value
            )
        except MrtsError as error:
            self._said.content = error_html(str(error))
            return
        assign(self._replace, value=False)
        names = " and ".join(path.name for path in paths)
        changed = ", ".join(bench.choices.edited()) or "nothing was changed"
        self._said.content = saved_html(f"Saved {names} ({changed}). {remark}")
