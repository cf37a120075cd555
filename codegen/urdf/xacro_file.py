# SPDX-License-Identifier: MIT
"""A xacro as the URDF that it becomes; needs the extra 'xacro' (xacrodoc).

A xacro computes: its `${…}` are expressions of Python, without builtins but not in a cage. One from a stranger is to be
trusted like a script. It is expanded by a process of its own, within limits of time and memory, and no shell is run.
"""

import json
import logging
import os
import subprocess  # this interpreter, a fixed module, no shell
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from signal import SIGXCPU
from typing import Any

from lxml import etree

from mrts.base.argument_types import require_extra
from mrts.base.errors import InputError
from mrts.base.formats.package_uri import file_of_uri, is_uri
from mrts.base.input_file import MAX_URDF_BYTES
from mrts.base.regular_file import read_regular

logger = logging.getLogger("mrts")

EXPANSION = "mrts_codegen.urdf.xacro_expansion"
"""The module that expands a xacro; imported by its own process alone, because it changes xacro."""

PROCESSOR_TIME = 10
"""For the expansion of one xacro [s]; published robots take less than one."""

MEMORY = 1 << 30
"""For the process that expands it [bytes]; published robots take a tenth of it."""

WAIT = 20.0
"""Until it is done [s]: twice its processor time, for a busy machine, or a file that is waited for."""

ADVICE = "Look for an expression or a macro without end, or expand it yourself and give the URDF."


_ANSWERS: dict[tuple[Path, tuple[tuple[str, str], ...]], tuple[list[tuple[int, int]], dict[str, Any]]] = {}
"""By path and arguments, state of the files of an expansion and its answer: a cell is read four times until it is
answered, and each expansion takes 0.2 s."""


def expanded(path: Path, arguments: Mapping[str, str]) -> bytes:
    """The URDF that a xacro becomes.

    It is expanded anew each time: what it includes, YAML that it loads, and the environment may have changed.
    """
    require_extra(path, "xacro", "xacrodoc")
    read_regular(path, "xacro", MAX_URDF_BYTES)
    key = path.absolute(), tuple(sorted(arguments.items()))
    before, answer = _ANSWERS.get(key, ([], {}))
    if not answer or before != _state(answer["files"]):
        limits = {"processor_time": PROCESSOR_TIME, "memory": MEMORY, "most_bytes": MAX_URDF_BYTES}
        answer = _answer(path, {"path": str(path), "arguments": dict(arguments), **limits})
        if "files" in answer:
            _ANSWERS[key] = _state(answer["files"]), answer
    for warning in answer["warnings"]:
        _warn_once(f"{path.name}: xacro warns: {warning}")
    if "rule" in answer:
        raise InputError(path, answer["rule"] or f"takes more than {MEMORY / 1e9:.2g} GB of memory to expand. {ADVICE}")
    for name in arguments:
        if name not in answer["known"]:
            there = ", ".join(answer["known"]) or "none"
            raise InputError(path, f"this xacro has no argument '{name}'; there are {there}.", key="xacro_args")
    return str(answer["urdf"]).encode()


def _state(files: Sequence[str]) -> list[tuple[int, int]]:
    """Last change and size of each file; zeros of those that are gone."""
    stats = [Path(file).stat() if Path(file).exists() else None for file in files]
    return [(0, 0) if stat is None else (stat.st_mtime_ns, stat.st_size) for stat in stats]


def _answer(path: Path, request: dict[str, Any]) -> dict[str, Any]:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}  # the same packages as here
    try:
        done = subprocess.run(  # noqa: S603
            [sys.executable, "-P", "-m", EXPANSION],
            input=json.dumps(request).encode(),
            capture_output=True,
            timeout=WAIT,
            env=environment,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(path, f"is not expanded after {WAIT:g} s. {ADVICE}") from None
    if done.returncode == -SIGXCPU:
        raise InputError(path, f"takes more than {PROCESSOR_TIME} s of processor time to expand. {ADVICE}")
    if done.returncode != 0:
        last = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise InputError(path, f"cannot be expanded: the attempt ended with code {done.returncode} ({last}). {ADVICE}")
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def with_found_meshes(path: Path, content: bytes) -> bytes:
    """The URDF of a xacro with absolute paths of its meshes, for reading it elsewhere; those not found stay."""
    root = etree.fromstring(content, etree.XMLParser(resolve_entities=False, no_network=True))
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if is_uri(name):
            try:
                mesh.set("filename", str(file_of_uri(path, name, path)))
            except InputError:
                continue
        elif name and not name.startswith("file://"):
            mesh.set("filename", str(path.absolute().parent / name))
    found: bytes = etree.tostring(root)
    return found


@cache
def _warn_once(text: str) -> None:
    """Log a warning: a cell is read several times until it is compiled."""
    logger.warning(text)
