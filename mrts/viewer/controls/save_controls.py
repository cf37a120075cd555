# SPDX-License-Identifier: MIT
"""Saving the cell and the motion as they were chosen; needs the extra 'view'."""

from collections.abc import Callable

import viser

from mrts.base.errors import MrtsError
from mrts.viewer.controls.bound_control import assign
from mrts.viewer.panel import error_html, note_html, saved_html
from mrts.viewer.workbench.saved_choices import save_choices
from mrts.viewer.workbench.workbench import Workbench

FIXED = "Only a cell file is written anew: this cell is from generated files, or a variant of a study."


def add_save_controls(gui: viser.GuiApi, bench: Workbench, later: Callable[[Callable[[], None]], None]) -> None:
    """Add names of the files, and the button that writes them, to the container that is open."""
    with gui.add_folder("Save as"):
        if bench.given.cell_path is None:
            gui.add_html(note_html(FIXED))
            return
        gui.add_html(note_html(f"Into {bench.given.cell_path.resolve().parent}"))
        cell = gui.add_text("cell file", "changed_cell.yaml")
        described = bench.given.description is not None
        motion = gui.add_text("motion file", "changed_motion.yaml" if described else "", visible=described)
        replace = gui.add_checkbox("replace files", initial_value=False)
        button = gui.add_button("Save")
        said = gui.add_html("")

    def save() -> None:
        try:
            paths, remark = save_choices(bench.given, bench.choices, cell.value, motion.value, overwrite=replace.value)
        except MrtsError as error:
            said.content = error_html(str(error))
            return
        assign(replace, value=False)
        names = " and ".join(path.name for path in paths)
        changed = ", ".join(bench.choices.edited()) or "nothing was changed"
        said.content = saved_html(f"Saved {names} ({changed}). {remark}")

    button.on_click(lambda _: later(save))
