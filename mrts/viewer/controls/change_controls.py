# SPDX-License-Identifier: MIT
"""All that changes a workbench's choices: numbers, places by gizmo and by sliders, configurations; extra 'view'."""

from collections.abc import Callable

import viser

from mrts.base.rigid_transform import RigidTransform
from mrts.studies.configurations import ConfigurationStudy
from mrts.viewer.controls.bound_control import assign
from mrts.viewer.controls.edit_controls import EditControls
from mrts.viewer.controls.gizmo import PlaceGizmo
from mrts.viewer.controls.places import places
from mrts.viewer.panel import note_html
from mrts.viewer.workbench.choices import Choices
from mrts.viewer.workbench.workbench import Workbench

SETTLED = 0.4
"""A control that rests so long is let go: the next change is another step to undo [s]."""

RANK, RANK_AGAIN = "Rank all configurations", "Rank them again"
NOWHERE = "nothing"
AS_GIVEN = "as in the cell file"
CONFIGURATIONS_SHOWN = 200
"""A longer menu is no help; the best come first."""


class ChangeControls:
    """The controls, in the container that is open; `later` takes work for the thread that follows them."""

    def __init__(
        self, server: viser.ViserServer, bench: Workbench, size: float, later: Callable[[Callable[[], None]], None]
    ) -> None:
        self._bench, gui = bench, server.gui
        self._still, self._open = 0.0, False
        self._study: ConfigurationStudy | None = None
        self._gizmo = PlaceGizmo(server, bench.given, size)
        self._edits = EditControls(gui, bench.given)
        self._places = {str(place): place for place in places(bench.given)}
        with gui.add_folder("Places"):
            self._place = gui.add_dropdown(
                "move", (NOWHERE, *self._places), hint="with the gizmo in the scene, or with the sliders below"
            )
            self._edits.add_offsets()
        self._shown_place = NOWHERE
        with gui.add_folder("Configuration"):
            self._add_configurations(gui, later)
        self.show()

    @property
    def unsettled(self) -> bool:
        """Whether a hand may still be on a control."""
        return self._open

    def follow(self, elapsed: float, speed_at: Callable[[Choices], float | None], held: RigidTransform) -> None:
        """Take over what was changed since the last call, and ask for its answer.

        Args:
            elapsed: Since then [s].
            speed_at: The speed to play choices at; None is the first one.
            held: Of the object in the world, at the moment that is shown.

        Raises:
            InputError: If a value breaks a rule.
        """
        bench = self._bench
        self._choose_place(held)
        changed = self._edits.changed(bench.choices)
        by_gizmo, let_go = self._gizmo.moved(bench.choices)
        if by_gizmo is not None:
            changed = (by_gizmo, str(self._gizmo.place))
        elif changed is None:
            changed = self._chosen_configuration()
        self._still += elapsed
        if changed is not None:
            choices, gesture = changed
            self._still, self._open = 0.0, True
            if choices is not bench.choices:
                bench.edit(choices, gesture, speed=speed_at(choices))
            self.show()
            self.follow_gizmo(held)
        elif self._open and (let_go or (self._still > SETTLED and not self._gizmo.dragged)):
            self._open = False
            bench.end_gesture()

    def follow_gizmo(self, held: RigidTransform) -> None:
        """Let the gizmo stand where its place is."""
        self._gizmo.follow(self._bench.choices, held)

    def show(self) -> None:
        """Show the choices as they are."""
        choices = self._bench.choices
        self._edits.show(choices)
        if self._menu is not None:
            self._show_configuration(self._menu, choices.configuration or AS_GIVEN)

    def show_study(self) -> None:
        """Say how far the ranking is, and offer the configurations once they are ranked."""
        study, menu = self._bench.study, self._menu
        if menu is None:
            return
        ranked = self._bench.ranked
        wanted = (RANK_AGAIN if study else RANK) if ranked is None else f"Stop ranking ({ranked[0]} of {ranked[1]})"
        if self._rank.label != wanted:
            self._rank.label = wanted
        if study is not self._study:
            self._study = study
            menu.visible = True
            self.show()

    def _show_configuration(self, menu: viser.GuiDropdownHandle[str], wanted: str) -> None:
        """Show the chosen one among those that were ranked last; the numbers in its name may be those of before."""
        labels = self._bench.configuration_labels()[:CONFIGURATIONS_SHOWN]
        options = tuple(dict.fromkeys((AS_GIVEN, wanted, *labels)))
        if options != menu.options:
            menu.options = options
        assign(menu, wanted)
        self._shown_configuration = wanted

    def _choose_place(self, held: RigidTransform) -> None:
        if self._place.value == self._shown_place:
            return
        self._shown_place = self._place.value
        place = self._places.get(self._shown_place)
        self._gizmo.choose(place)
        self._edits.choose(place, self._bench.choices)
        self.follow_gizmo(held)

    def _add_configurations(self, gui: viser.GuiApi, later: Callable[[Callable[[], None]], None]) -> None:
        self._menu: viser.GuiDropdownHandle[str] | None = None
        if fixed := self._bench.fixed_configuration:
            gui.add_html(note_html(fixed))
            return
        self._rank: viser.GuiButtonHandle = gui.add_button(
            RANK, hint="of the cell as it is now; takes seconds, and everything else goes on"
        )
        self._rank.on_click(lambda _: later(self._rank_or_stop))
        self._menu = gui.add_dropdown("configuration", (AS_GIVEN,), visible=False)
        self._shown_configuration = AS_GIVEN

    def _rank_or_stop(self) -> None:
        if self._bench.ranked is None:
            self._bench.rank()
        else:
            self._bench.stop_ranking()

    def _chosen_configuration(self) -> tuple[Choices, str] | None:
        menu, bench = self._menu, self._bench
        if menu is None or menu.value == self._shown_configuration:
            return None
        self._shown_configuration = menu.value
        return bench.with_configuration(menu.value if menu.value != AS_GIVEN else ""), "configuration"
