# SPDX-License-Identifier: MIT
"""Controls of how the scene and the page look; needs the extra 'view'."""

from collections.abc import Callable
from functools import partial

import viser

from mrts.viewer.scene import ViewerScene


class ViewControls:
    """What is drawn, in which colours, and from where."""

    def __init__(
        self, server: viser.ViserServer, scene: ViewerScene, later: Callable[[Callable[[], None]], None]
    ) -> None:
        self._server, self._scene = server, scene
        gui = server.gui
        with gui.add_folder("Scene"):
            self._frames = gui.add_checkbox("frames", initial_value=False, hint="of bases, tips and the object")
            self._names = gui.add_checkbox("names", initial_value=True)
            self._shadows = gui.add_checkbox("shadows", initial_value=False, hint="for a good graphics card")
            self._dark = gui.add_checkbox("dark", initial_value=False)
            fit = gui.add_button("Show the whole cell")
        fit.on_click(lambda event: later(partial(self._fit, event.client)))
        self._shown = (False, True, False, False)

    def follow(self) -> bool:
        """Do what was changed since the last call; whether anything was."""
        wanted = (self._frames.value, self._names.value, self._shadows.value, self._dark.value)
        if wanted == self._shown:
            return False
        frames, names, shadows, dark = wanted
        self._scene.show_frames(visible=frames)
        self._scene.show_names(visible=names)
        if shadows != self._shown[2]:
            self._scene.show_shadows(visible=shadows)
        if dark != self._shown[3]:
            self._server.gui.configure_theme(
                control_width="large", dark_mode=dark, show_logo=False, show_share_button=False
            )
            self._scene.darken(dark=dark)
        self._shown = wanted
        return True

    def _fit(self, client: viser.ClientHandle | None) -> None:
        if client is not None:
            self._scene.fit(client)
