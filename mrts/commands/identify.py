# SPDX-License-Identifier: MIT
"""`mrts identify`."""

from pathlib import Path
from typing import Any

from click import argument, option

from mrts.base.atomic_file import write_text_atomically
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, Outputs, warn, working
from mrts.commands.options import Named, Written


@options.command
@options.cell
@argument("recording", type=Named(), metavar="RECORDING",
          help="joint positions and efforts of arms that hold nothing: ROS 2 bag with sensor_msgs/JointState, or CSV "
          "table with t, q.ROBOT/JOINT, tau.ROBOT/JOINT")  # fmt: skip
@option("-o", "--output", type=Written(), required=True, metavar="FILE",
        help="the `motors` block of each recorded robot, for the cell file (YAML)")  # fmt: skip
@option("--cutoff", type=float, metavar="HZ",
        help="of the filter of positions and efforts (default: 20, or a tenth of the sampling rate where that is "
        "less)")  # fmt: skip
@options.plot("a figure of what is left over for each robot")
def run(cell: Path, recording: Path, output: Path, plot: Path | None = None, **given: Any) -> int:
    """Find armature and friction of the motors in a recording of the arms' free motion.

    Examples:
        mrts identify cell.yaml recorded.csv -o motors.yaml
        mrts identify cell.yaml recorded.csv -o motors.yaml --cutoff 30 --plot plots
    """
    from mrts.identification.identify import identify
    from mrts.motion.joint_recording import load_recording

    compiled = options.compiled_cell(cell)
    with working(f"reading {recording}"):
        recorded = load_recording(recording)
    with working(f"identifying motors of {compiled.name}"):
        found = identify(compiled, recorded, **given)
    outputs = Outputs()
    if found.empty:
        warn(f"there is no parameter that is known of all joints of an arm: {output} not written")
    else:
        outputs.write(output, lambda path: write_text_atomically(path, found.to_yaml()))
    if plot is not None:
        from mrts.plots import motor_plot, write_plots

        outputs.write(plot, lambda folder: write_plots([*map(motor_plot, found.arms)], folder))
    lines = [f"{compiled.name}: {found.sentence()}", *map(str, found.remarks), f"\n{found.to_yaml()}"]
    return outputs.answer(lines, INFEASIBLE if found.empty else FEASIBLE)
