# SPDX-License-Identifier: MIT
"""What the panel's page of views gets besides: another result, and files of what is shown; needs the extra 'view'."""

from collections.abc import Sequence

import viser

from mrts.scaling.result import ScalingResult
from mrts.viewer.plots.film_controls import FilmControls
from mrts.viewer.plots.other_result import OtherResult
from mrts.viewer.scene_arms import Urdfs
from mrts.viewer.viewer_part import ViewerPart

Others = Sequence[tuple[str, ScalingResult]]
"""Results with a trajectory, each with its name for people."""


def beside_parts(server: viser.ViserServer, urdfs: Urdfs, others: Others) -> list[ViewerPart]:
    """Add controls to the container that is open, and what they steer to the scene.

    Args:
        server: Where.
        urdfs: As the scene has them.
        others: Of which the first stands in the scene; all are in pictures and films.
    """
    motions = [(name, done) for name, result in others if (done := result.trajectory) is not None]
    shown: list[ViewerPart] = [OtherResult(server, *others[0])] if others else []
    return [*shown, FilmControls(server.gui, urdfs, motions)]
