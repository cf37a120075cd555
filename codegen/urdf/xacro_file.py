# SPDX-License-Identifier: MIT
"""A xacro as the URDF that it becomes; needs the extra 'xacro' (xacrodoc).

A xacro computes: its `${…}` are expressions of Python, without builtins but not in a cage. One from a stranger is to be
trusted like a script.
"""

import glob
import logging
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from threading import Lock
from typing import Any
from xml.sax.saxutils import escape

from lxml import etree

from mrts.base.errors import InputError
from mrts.base.formats.package_uri import file_of_uri, is_uri, no_package, package_folder
from mrts.base.input_file import MAX_URDF_BYTES
from mrts.base.regular_file import read_regular

logger = logging.getLogger("mrts")

ARGUMENT = re.compile(r"<xacro:arg\s[^>]*?name\s*=\s*[\"']([^\"']+)[\"']|\$\(arg\s+([^\s)]+)\s*\)|\barg\('([^']+)'\)")
"""Where a xacro declares or uses an argument."""

_ONE_AT_A_TIME = Lock()
"""xacro keeps what it is at in variables of its module."""


def expanded(path: Path, arguments: Mapping[str, str]) -> bytes:
    """The URDF that a xacro becomes.

    It is expanded anew each time: what it includes, YAML that it loads, and the environment may have changed.

    Args:
        path: The file.
        arguments: Values of its arguments, by name.

    Raises:
        InputError: If xacrodoc is missing, it cannot be expanded, or there is no such argument.
    """
    if find_spec("xacrodoc") is None:
        raise InputError(path, "reading a xacro needs xacrodoc: pip install 'mrts[xacro]'.")
    read_regular(path, "xacro", MAX_URDF_BYTES)
    with _ONE_AT_A_TIME, _as_ours(path):
        import xacro  # noqa: PLC0415 (an extra, needed when a xacro is)
        from xacrodoc import XacroDoc  # noqa: PLC0415

        xacro.all_includes.clear()
        try:
            # as an include, so that what it includes is relative to itself
            document = XacroDoc.from_includes([_as_included(path)], subargs=dict(arguments), resolve_packages=False)
            text: bytes = document.dom.toxml().encode()
        except Exception as error:  # noqa: BLE001 (its expressions raise what Python has)
            reason = " ".join(str(error).split()) or type(error).__name__
            raise InputError(
                path, _no_package(reason) or f"cannot be expanded ({reason}).{_missing_argument(error)}"
            ) from None
        _check_arguments(path, arguments, {path, *map(Path, xacro.all_includes)})
    if len(text) > MAX_URDF_BYTES:
        raise InputError(path, f"becomes a URDF of {len(text)} bytes; a URDF has at most {MAX_URDF_BYTES}.")
    return text


def with_found_meshes(path: Path, content: bytes) -> bytes:
    """The URDF of a xacro with absolute paths of its meshes, for reading it elsewhere; those not found stay.

    Args:
        path: The xacro.
        content: The URDF.
    """
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


def _as_included(path: Path) -> str:
    """A path as an <xacro:include> has it: neither a pattern, nor an expression, nor XML."""
    text = re.sub(r"(\$+[{(])", r"$\1", glob.escape(str(path.absolute())))
    return escape(text, {'"': "&quot;"})


@contextmanager
def _as_ours(path: Path) -> Iterator[None]:
    """Let xacrodoc find packages where URIs find them, and xacro warn as we do."""
    import xacro  # noqa: PLC0415 (an extra, needed when a xacro is)
    from xacrodoc import packages  # noqa: PLC0415

    def folder(package: str) -> str:
        found = package_folder(package, path)
        if found is None:
            raise packages.PackageNotFoundError(package)
        return str(found)

    def warning(*words: object, **_of_print: object) -> None:
        _warn_once(f"{path.name}: xacro warns: {' '.join(map(str, words))}")

    before = packages.get_path, xacro.warning, xacro.print_location
    packages.get_path, xacro.warning, xacro.print_location = folder, warning, lambda: None
    try:
        yield
    finally:
        packages.get_path, xacro.warning, xacro.print_location = before


@cache
def _warn_once(text: str) -> None:
    """Log a warning: a cell is read several times until it is compiled."""
    logger.warning(text)


def _no_package(reason: str) -> str:
    """What to do where a package is missing, of which xacrodoc says no more than the name; empty where none is."""
    missing = re.search(r"Package not found: (\S+)", reason)
    return "" if missing is None else f"includes a file of a package: {no_package(missing[1])}."


def _missing_argument(error: Exception) -> str:
    """What to do where an argument has no value."""
    if type(error).__name__ == "ArgException" or "Undefined substitution argument" in str(error):
        return " Give it in 'xacro_args: {NAME: VALUE}' of the robot, to mrts new as --xacro-arg NAME=VALUE."
    return ""


def _check_arguments(path: Path, arguments: Mapping[str, str], files: set[Path]) -> None:
    """Refuse an argument that nothing in the files asks for: xacro would pass over it."""
    if not arguments:
        return
    known: dict[str, Any] = {}
    for file in sorted(files):
        for names in ARGUMENT.findall(read_regular(file, "xacro", MAX_URDF_BYTES).decode(errors="replace")):
            known |= dict.fromkeys(filter(None, names))
    for name in arguments:
        if name not in known:
            there = ", ".join(known) or "none"
            raise InputError(path, f"this xacro has no argument '{name}'; there are {there}.", key="xacro_args")
