# SPDX-License-Identifier: MIT
"""What reading and writing a ROS 2 bag share; needs the extra 'ros' (rosbags)."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from mrts.base.errors import InputError
from mrts.base.input_file import read_text
from mrts.base.regular_file import is_folder, open_regular
from mrts.base.yaml_parser import MAX_YAML_BYTES, parse_yaml

NANOSECONDS = 1_000_000_000
"""A second in the unit of a bag's time stamps."""

METADATA = "metadata.yaml"

MAX_BAG_BYTES = 500_000_000
"""Of one file; a trajectory of a million points takes half of it."""


@cache
def message_types() -> Any:
    """The message types of the oldest ROS 2 that is supported; the ones used here have not changed since."""
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 (an extra, needed when a bag is)

    return get_typestore(Stores.ROS2_HUMBLE)


def is_bag(path: Path) -> bool:
    """Whether a path names a bag: a folder, or one of its files by itself."""
    return is_folder(path) or path.suffix.lower() in {".mcap", ".db3"}


def joint_column(topic: str, joint: str) -> str:
    """What a joint of a topic is called: after the topic's first name, as in /ROBOT/joint_states."""
    return f"{topic.strip('/').partition('/')[0]}/{joint}"


def bag_messages(path: Path, *kinds: str) -> dict[str, list[tuple[int, Any]]]:
    """All messages of some types; of types that ROS 2 itself does not have, as the bag defines them.

    Returns:
        By topic in the order of their names: when each was recorded [ns], and the message.

    Raises:
        InputError: If the extra 'ros' is missing, it is no bag, or holds no such message.
    """
    if find_spec("rosbags") is None:
        raise InputError(path, "reading a ROS 2 bag needs rosbags: pip install 'mrts[ros]'.")
    from rosbags.rosbag2 import Reader  # noqa: PLC0415 (an extra, needed when a bag is)

    _check_files(path)
    found: dict[str, list[tuple[int, Any]]] = {}
    try:
        with Reader(path) as bag:
            topics = sorted(bag.topics)
            wanted = [connection for connection in bag.connections if connection.msgtype in kinds]
            types = {connection.id: _types_of(path, connection) for connection in wanted}
            for connection, stamp, data in bag.messages(wanted) if wanted else ():
                message = types[connection.id].deserialize_cdr(data, connection.msgtype)
                found.setdefault(connection.topic, []).append((stamp, message))
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001 (what the reader raises of damaged bags is no short list)
        reason = " ".join(str(error).split()) or type(error).__name__  # a YAML error draws where it is
        raise InputError(path, f"cannot be read as a ROS 2 bag: {reason}") from None
    if not found:
        raise InputError(path, f"holds no message {' or '.join(kinds)}; its topics are {', '.join(topics) or 'none'}.")
    return dict(sorted(found.items()))


def _types_of(path: Path, connection: Any) -> Any:
    """The types to read the messages of a connection with.

    Raises:
        InputError: If they are not those of ROS 2 itself, and the bag does not define them.
    """
    if connection.msgtype in message_types().types:
        return message_types()
    from rosbags.interfaces import MessageDefinitionFormat  # noqa: PLC0415 (an extra, needed when a bag is)
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415

    if connection.msgdef.format != MessageDefinitionFormat.MSG:
        raise InputError(
            path,
            f"does not define {connection.msgtype}, as bags of ROS 2 before Iron in SQLite do not. Record it in MCAP: "
            "`ros2 bag record --storage mcap`, or convert it: `ros2 bag convert`.",
            key=connection.topic,
        )
    types = get_typestore(Stores.EMPTY)  # all of them as the bag has them: those of another release may differ
    types.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    return types


def _check_files(path: Path) -> None:
    """Refuse what rosbags would wait for, or take long to parse."""
    if not path.is_dir():
        with open_regular(path, "bag", MAX_BAG_BYTES):
            return
    if not (path / METADATA).exists():
        raise InputError(path, f"this folder holds no {METADATA}; a ROS 2 bag does. Name the .mcap file by itself.")
    try:
        parse_yaml(read_text(path / METADATA, "description of a bag", MAX_YAML_BYTES))
    except ValueError as error:
        raise InputError(path / METADATA, f"this description of a bag {error}.") from None
    for file in path.iterdir():
        if not file.is_dir():
            with open_regular(file, "file of a bag", MAX_BAG_BYTES):
                pass
