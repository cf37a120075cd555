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
    "motors.c": ALL,
    "terms.c": frozenset({"terms"}),
    "limits.c": WITH_ROWS,
    "ideal_rows.c": WITH_ROWS,
    "motor_rows.c": WITH_ROWS,
    "wrench_form.c": OF_WRENCH_FORM,
    "speeds.c": frozenset({"range", "share"}),
    "range_programs.c": frozenset({"range"}),
    "range_of_speed.c": frozenset({"range"}),
    "range.c": frozenset({"range"}),
    "guaranteed.c": frozenset({"range"}),
    "load_corners.c": frozenset({"range"}),
    "share_of_speed.c": frozenset({"share"}),
    "share.c": frozenset({"share"}),
    "torques.c": frozenset({"torques"}),
}
"""In the order in which one text includes them."""

OF_MOTORS = frozenset(
    {"motors.c", "motor_rows.c", "speeds.c", "range_of_speed.c", "share_of_speed.c"}
    | {"speed_intervals.h", "speed_intervals.c"}
)
"""Of all these files, those of a cell with motors; likewise of ideal ones. Others are of both."""

OF_IDEAL = frozenset({"ideal_rows.c"})

KERNEL_FILES: dict[str, frozenset[str]] = {
    "numbers.h": ALL,
    "rows.h": WITH_ROWS,
    "rows.c": WITH_ROWS,
    "linear_programs.h": OF_WRENCH_FORM,
    "linear_programs.c": OF_WRENCH_FORM,
    "basis/kept_basis.h": OF_WRENCH_FORM,
    "basis/kept_basis.inc": OF_WRENCH_FORM,
    "basis/kept_basis.c": OF_WRENCH_FORM,
    "speed_intervals.h": frozenset({"range", "share"}),
    "speed_intervals.c": frozenset({"range", "share"}),
    "quadratic_programs.h": frozenset({"torques"}),
    "quadratic_programs.c": frozenset({"torques"}),
}
"""Files of mrts/kernel/c that a library carries as they are."""

MORE_OF_MOTORS: dict[str, frozenset[str]] = {
    "linear_programs.h": frozenset({"share"}),
    "linear_programs.c": frozenset({"share"}),
    "basis/kept_basis.h": frozenset({"share"}),
    "basis/kept_basis.inc": frozenset({"share"}),
    "basis/kept_basis.c": frozenset({"share"}),
}
"""More parts that need a file where the cell has motors."""


def chosen(files: dict[str, frozenset[str]], parts: Iterable[str], *, motors: bool = False) -> list[str]:
    """What the parts need, in the order of the table.

    Args:
        files: A table of them.
        parts: Of `PARTS`.
        motors: Whether the cell has motors that are not ideal.
    """
    wanted, left_out, more = set(parts), OF_IDEAL if motors else OF_MOTORS, MORE_OF_MOTORS if motors else {}
    needed = {file: needed_by | more.get(file, frozenset()) for file, needed_by in files.items()}
    return [file for file, needed_by in needed.items() if needed_by & wanted and file not in left_out]


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
