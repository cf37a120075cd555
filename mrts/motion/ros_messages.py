# SPDX-License-Identifier: MIT
"""What reading and writing a ROS 2 bag share; needs the extra 'ros' (rosbags)."""

from functools import cache
from typing import Any

NANOSECONDS = 1_000_000_000
"""A second in the unit of a bag's time stamps."""


@cache
def message_types() -> Any:
    """The message types of the oldest ROS 2 that is supported; the ones used here have not changed since."""
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 (an extra, needed when a bag is)

    return get_typestore(Stores.ROS2_HUMBLE)
