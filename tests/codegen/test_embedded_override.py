"""An exported plan as the controller plays it: in float, sanitized, on a Cortex-M7, the same as Python."""

from functools import cache

import numpy as np
import pytest
from embedded_target import FOLDER, cross_compile, missing_tools, run_on_target
from exported_library import SANITIZED, compiles_cleanly, link, run, sources
from shipped_cells import DATA

import mrts
from mrts.cli import main

pytestmark = [pytest.mark.slow, pytest.mark.parametrize("precision", ["double", "float"])]

MAIN = FOLDER / "play_override.c"
DEFINES = ("-DPREFIX=dual_ur5", '-DLIBRARY_HEADER="dual_ur5_override.h"')
TICKS, HELD = 1500, 25
PLACE, TORQUE = 1e-4, 1e-3
"""Of the plan's duration, and of a torque limit: what float may differ by after so many ticks."""

PRINTED = 1e-8
"""Relative rounding of what is printed."""


@pytest.fixture(scope="module")
def played():
    """The override of a plan, and its states under the wishes that the C draws too."""
    folder = DATA / "dual_ur5"
    result = mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "lift_and_turn.yaml"))
    override, drawn, wishes = mrts.SpeedOverride(result), 1, []
    for _ in range(TICKS // HELD):
        drawn = (drawn * 1103515245 + 12345) & 0x7FFFFFFF
        wishes.append((drawn >> 16) % 13 / 10)
    return result, override, override.play(np.repeat(wishes, HELD))


@pytest.fixture(scope="module")
def exports(played, tmp_path_factory):
    """The folder of the plan's library by precision, exported when it is first asked for."""
    place = tmp_path_factory.mktemp("plan")
    mrts.save_result(played[0], place / "result.npz")

    @cache
    def exported(precision):
        cell = DATA / "dual_ur5" / "cell.yaml"
        given = ["--plan", str(place / "result.npz"), "--precision", precision, "-o", str(place / precision)]
        assert main(["export", str(cell), *given]) == 0
        return place / precision

    return exported


def states_of(text):
    """Times and torques that the C printed."""
    numbers = np.array([line.split() for line in text.splitlines()], dtype=float)
    assert len(numbers) == TICKS
    return numbers[:, 0], numbers[:, 1:]


def test_it_plays_what_python_plays_and_refuses_what_is_no_wish(played, exports, precision, tmp_path):
    _, override, states = played
    program = link(exports(precision), MAIN, tmp_path / "play", *DEFINES, *SANITIZED, "-O1")
    time, torque = states_of(run(program))
    most = np.concatenate([robot.torque_upper for robot in override.cell.robots])
    near = (PLACE, TORQUE) if precision == "float" else (PRINTED, PRINTED)
    assert np.max(np.abs(time - states["time"])) <= near[0] * override.duration
    assert np.max(np.abs(torque - states["torque"]) / most) <= near[1]


def test_a_plan_compiles_without_a_warning_as_c_and_cpp(exports, precision, tmp_path):
    folder = exports(precision)
    compiles_cleanly(folder, sources(folder), tmp_path, [folder / "include" / "dual_ur5_override.h"], DEFINES)


def test_a_cortex_m7_plays_what_the_host_plays(exports, precision, tmp_path):
    if missing_tools():
        pytest.skip(f"needs {' '.join(missing_tools())}")
    folder = exports(precision)
    board = run_on_target(cross_compile(folder, MAIN, tmp_path / "image.elf", *DEFINES))
    assert board.returncode == 0
    host = states_of(run(link(folder, MAIN, tmp_path / "play", *DEFINES, "-O2", "-ffp-contract=off")))
    near = PRINTED if precision == "double" else TORQUE / 10
    for ours, theirs in zip(host, states_of(board.stdout), strict=True):
        assert np.max(np.abs(ours - theirs)) <= near * np.max(np.abs(ours))
