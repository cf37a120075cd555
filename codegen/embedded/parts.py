# SPDX-License-Identifier: MIT
"""Parts of a library, and the files that each of them needs."""

from collections.abc import Iterable

from mrts.base.errors import InputError

PARTS = ("terms", "range", "share", "torques")
"""What `--functions` chooses from."""

ALL = frozenset(PARTS)
WITH_ROWS = ALL - {"terms"}
OF_WRENCH_FORM = frozenset({"range", "torques"})

MODEL_FUNCTIONS: dict[str, frozenset[str]] = {
    "terms": frozenset({"terms"}),
    "wrench_form": OF_WRENCH_FORM,
    "fixed_distribution": frozenset({"share"}),
}
"""Generated functions, by the parts that need them; likewise the files below, by their templates."""

DECLARATIONS: dict[str, frozenset[str]] = {f"{part}.h": frozenset({part}) for part in PARTS}

LIBRARY_PARTS: dict[str, frozenset[str]] = {
    "sample.c": ALL,
    "settings.c": ALL,
    "horizon.c": ALL,
    "terms.c": frozenset({"terms"}),
    "limits.c": WITH_ROWS,
    "wrench_form.c": OF_WRENCH_FORM,
    "range.c": frozenset({"range"}),
    "load_corners.c": frozenset({"range"}),
    "share.c": frozenset({"share"}),
    "torques.c": frozenset({"torques"}),
}
"""In the order in which one text includes them."""

KERNEL_FILES: dict[str, frozenset[str]] = {
    "numbers.h": ALL,
    "rows.h": WITH_ROWS,
    "rows.c": WITH_ROWS,
    "linear_programs.h": OF_WRENCH_FORM,
    "linear_programs.c": OF_WRENCH_FORM,
    "quadratic_programs.h": frozenset({"torques"}),
    "quadratic_programs.c": frozenset({"torques"}),
}
"""Files of mrts/kernel/c that a library carries as they are."""


def chosen(files: dict[str, frozenset[str]], parts: Iterable[str]) -> list[str]:
    """What the parts need, in the order of the table."""
    wanted = set(parts)
    return [file for file, needed_by in files.items() if needed_by & wanted]


def is_whole(parts: Iterable[str]) -> bool:
    """Whether these are all parts: tests and example use all of them."""
    return set(parts) == ALL


def check_parts(parts: Iterable[str]) -> None:
    """Refuse a part that does not exist.

    Raises:
        InputError: If there is one, or none at all.
    """
    given = tuple(parts)
    for part in given:
        if part not in PARTS:
            raise InputError("--functions", f"there are {', '.join(PARTS)}.", value=part)
    if not given:
        raise InputError("--functions", f"choose at least one of {', '.join(PARTS)}.")
