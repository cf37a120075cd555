# SPDX-License-Identifier: MIT
"""A result as files and text. A new format of the trajectory is one file and one line in `TRAJECTORY_FORMATS`.

May import base to starting. Start at `saved_result.py`.
"""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult


@dataclass(frozen=True)
class TrajectoryFormat:
    """A format in which `mrts scale` writes the scaled trajectory, by the option of its name.

    Attributes:
        meaning: What the option's help says.
        writer: "file.function" of this folder; the function takes a result and a path, and writes all or nothing.
        is_folder: Whether the path is that of a new folder, not of a file.
        needs: The package that the writer imports and the extra that brings it; None if it needs none.
    """

    meaning: str
    writer: str
    is_folder: bool = False
    needs: tuple[str, str] | None = None

    def write(self, result: "ScalingResult", path: Path) -> None:
        """Write a trajectory; the writer is imported now.

        Raises:
            InputError: If there is no trajectory, or it cannot be written.
        """
        module, function = self.writer.split(".")
        getattr(import_module(f"mrts.output.{module}"), function)(result, path)


TRAJECTORY_FORMATS: dict[str, TrajectoryFormat] = {
    "csv": TrajectoryFormat("as a table", "trajectory_table.write_trajectory_csv"),
    "ros-bag": TrajectoryFormat(
        "as a ROS 2 bag (MCAP; needs the extra 'ros')",
        "ros_bag.write_ros_bag",
        is_folder=True,
        needs=("rosbags", "ros"),
    ),
    "ros-bag-merged": TrajectoryFormat(
        "as a ROS 2 bag with one trajectory of all arms",
        "ros_bag.write_merged_ros_bag",
        is_folder=True,
        needs=("rosbags", "ros"),
    ),
}
