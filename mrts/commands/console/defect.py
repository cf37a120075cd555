# SPDX-License-Identifier: MIT
"""What is said of an exception that nobody expected."""

import sys
import traceback
from pathlib import Path

from mrts.base.version import __version__

PACKAGE = Path(__file__).resolve().parent.parent
LONGEST_REASON = 300
"""Letters of the exception's own words that are shown."""

REPORT = (
    "This is a defect of mrts, whatever the input. Please report it, with the files and with what the same command "
    "prints with --debug."
)


def describe_defect(error: BaseException) -> str:
    """One paragraph: what happened, where, and what to do."""
    if isinstance(error, MemoryError):
        return f"out of memory{_place(error)}. Give the motion fewer samples, or the load fewer uncertain parameters."
    said = "".join(traceback.format_exception_only(error)).strip().splitlines()
    reason = " ".join(" ".join(said).split())
    if len(reason) > LONGEST_REASON:
        reason = f"{reason[:LONGEST_REASON]}…"
    return f"internal error{_place(error)}: {reason.rstrip('.')}. {REPORT}"


def _place(error: BaseException) -> str:
    """The innermost line of ours."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if _is_ours(frame.filename)]
    return f" at {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""


def _is_ours(filename: str) -> bool:
    path = Path(filename).resolve()
    return path.is_relative_to(PACKAGE) or path.parent.name in {"mrts_codegen", "codegen"}


def trace(error: BaseException) -> str:
    """The traceback and the versions that a report needs."""
    versions = f"mrts {__version__}, Python {sys.version.split()[0]} on {sys.platform}"
    return "".join(traceback.format_exception(error)) + versions
