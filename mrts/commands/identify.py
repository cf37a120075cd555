# SPDX-License-Identifier: MIT
"""`mrts identify`."""

import argparse
from pathlib import Path

from mrts.base.errors import InputError
from mrts.commands.options.common import add_plot, cell_option, plot_form
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import say, warn

EXAMPLES = """\
examples:
  mrts identify cell.yaml recorded.csv -o motors.yaml
  mrts identify cell.yaml recorded.csv -o motors.yaml --cutoff 30 --plot plots"""


def add(verb: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    verb.add_argument("cell", type=Path, metavar="CELL", help="cell file, or a folder that `mrts generate` wrote")
    verb.add_argument("recording", type=Path, metavar="RECORDING",
                      help="joint positions and efforts of arms that hold nothing: ROS 2 bag with "
                      "sensor_msgs/JointState, or CSV table with t, q.ROBOT/JOINT, tau.ROBOT/JOINT")  # fmt: skip
    verb.add_argument("-o", "--output", type=Path, required=True, metavar="FILE",
                      help="the `motors` block of each recorded robot, for the cell file (YAML)")  # fmt: skip
    verb.add_argument("--cutoff", type=float, metavar="HZ",
                      help="of the filter of positions and efforts (default: 20, or a tenth of the sampling rate where "
                      "that is less)")  # fmt: skip
    add_plot(verb, "a figure of what is left over for each robot")
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Identify the motors."""
    from mrts.identification.identify import identify
    from mrts.motion.joint_recording import load_recording

    options.plot_format = plot_form(options)
    check_outputs({"--output": options.output}, {"--plot": options.plot})
    cell = cell_option(options.cell)
    with working(f"reading {options.recording}"):
        recording = load_recording(options.recording)
    with working(f"identifying motors of {cell.name}"):
        try:
            found = identify(cell, recording, cutoff=options.cutoff)
        except InputError as error:
            if error.where == "cutoff":
                raise InputError("--cutoff", error.rule, value=error.value) from None
            raise
    outputs = Outputs()
    if found.empty:
        warn(f"there is no parameter that is known of all joints of an arm: {options.output} not written")
    else:
        with outputs.attempt(options.output):
            found.write_yaml(options.output)
    if options.plot is not None:
        with outputs.attempt(options.plot):
            from mrts.plots import write_motor_plots

            write_motor_plots(found, options.plot, options.plot_format)
    say(f"{cell.name}: {found.sentence()}", "bad" if found.empty else "strong")
    for remark in found.remarks:
        say(str(remark), "note")
    say(f"\n{found.table()}")
    for line in outputs.lines():
        say(line)
    return outputs.code(INFEASIBLE if found.empty else FEASIBLE)
