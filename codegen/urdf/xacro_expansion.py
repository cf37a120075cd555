# SPDX-License-Identifier: MIT
"""The process that expands one xacro: its expressions may compute without end, so it runs within limits.

Started by `mrts_codegen.urdf.xacro_file`: a request comes as JSON on standard input, the answer leaves as JSON on
standard output. It imports little, because a cell is read several times.
"""

import glob
import json
import re
import resource
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import xacro
from xacrodoc import XacroDoc, packages

ARGUMENT = re.compile(r"<xacro:arg\s[^>]*?name\s*=\s*[\"']([^\"']+)[\"']|\$\(arg\s+([^\s)]+)\s*\)|\barg\('([^']+)'\)")
"""Where a xacro declares or uses an argument."""


def main() -> None:
    """Answer with `warnings`, and `urdf`, `files`, `known` arguments; or with `rule`, null where memory lacks."""
    request = json.load(sys.stdin)
    _limit(resource.RLIMIT_CPU, request["processor_time"])
    _limit(resource.RLIMIT_AS, request["memory"])
    answer: dict[str, Any] = {"warnings": []}
    try:
        answer |= _expanded(Path(request["path"]), request["arguments"], request["most_bytes"], answer["warnings"])
    except Exception as error:  # noqa: BLE001 (expressions raise what Python has)
        answer["rule"] = _rule(error)
    json.dump(answer, sys.stdout)


def _limit(which: int, most: int) -> None:
    _, hard = resource.getrlimit(which)
    resource.setrlimit(which, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _expanded(path: Path, arguments: Mapping[str, str], most_bytes: int, warnings: list[str]) -> dict[str, Any]:
    """The answer where the xacro can be expanded; adds to `warnings`."""

    def folder(package: str) -> str:
        from mrts.base.formats.package_uri import package_folder  # noqa: PLC0415 (only where a package is named)

        found = package_folder(package, path)
        if found is None:
            raise packages.PackageNotFoundError(package)
        return str(found)

    # packages are found where URIs find them, and warnings are told by mrts
    packages.get_path = folder
    xacro.warning = lambda *words, **_of_print: warnings.append(" ".join(map(str, words)))
    xacro.print_location = lambda: None
    # as an include, so that what it includes is relative to itself
    document = XacroDoc.from_includes([_as_included(path)], subargs=dict(arguments), resolve_packages=False)
    urdf: str = document.dom.toxml()
    if (size := len(urdf.encode())) > most_bytes:
        return {"rule": f"becomes a URDF of {size} bytes; a URDF has at most {most_bytes}."}
    files = {path, *map(Path, xacro.all_includes)}
    return {"urdf": urdf, "files": sorted(map(str, files)), "known": _known_arguments(files) if arguments else []}


def _as_included(path: Path) -> str:
    """A path as an <xacro:include> has it: neither a pattern, nor an expression, nor XML."""
    text = re.sub(r"(\$+[{(])", r"$\1", glob.escape(str(path.absolute())))
    return escape(text, {'"': "&quot;"})


def _known_arguments(files: set[Path]) -> list[str]:
    texts = (file.read_text(encoding="utf-8", errors="replace") for file in sorted(files))
    return list(dict.fromkeys(name for text in texts for names in ARGUMENT.findall(text) for name in names if name))


def _rule(error: BaseException) -> str | None:
    """What is wrong with a xacro that cannot be expanded, and what to do; None where memory lacks."""
    cause = error
    while isinstance(inner := getattr(cause, "exc", None), BaseException):
        cause = inner
    if isinstance(cause, MemoryError):
        return None
    missing = type(error).__name__ == "ArgException" or "Undefined substitution argument" in str(error)
    advice = " Give it in 'xacro_args: {NAME: VALUE}' of the robot, to mrts new as --xacro-arg NAME=VALUE."
    reason = " ".join(str(error).split()) or type(error).__name__
    package = re.search(r"Package not found: (\S+)", reason)  # all that xacrodoc says, twice
    if package is not None:
        from mrts.base.formats.package_uri import no_package  # noqa: PLC0415 (likewise)

        return f"includes a file of a package: {no_package(package[1])}."
    return f"cannot be expanded ({reason}).{advice if missing else ''}"


if __name__ == "__main__":
    main()
