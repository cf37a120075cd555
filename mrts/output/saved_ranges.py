# SPDX-License-Identifier: MIT
"""Ranges of c² at every sample as arrays of a saved result, and back; R ranges, N samples, B binding rows in all."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.load_box import LoadPoint
from mrts.limits.rows import ActiveRow, Side
from mrts.output.saved_json import (
    DAMAGED,
    ConflictEntry,
    Description,
    EndEntry,
    LoadEntry,
    PlanReserveEntry,
    RatedEntry,
    ReserveEntry,
    RowEntry,
)
from mrts.program.infeasibility import Conflict
from mrts.program.range_ends import BindingRows
from mrts.program.range_status import RangeStatus
from mrts.program.reserve import PlanReserve, Reserve
from mrts.program.sample_ranges import SampleRanges
from mrts.scaling.range import RangeEnd, ScalingRange, intersect

STATUSES = tuple(RangeStatus)
"""A sample's status is saved as its place in this order."""

Arrays = dict[str, NDArray[Any]]


SIDES: tuple[Side, Side] = ("lower", "upper")


class Tables:
    """The distinct rows and loads of a result: elsewhere they are saved as their places here."""

    def __init__(self) -> None:
        self._rows: dict[ActiveRow, int] = {}
        self._loads: dict[tuple[tuple[tuple[str, float], ...], tuple[float, ...]], int] = {}

    def row(self, row: ActiveRow) -> int:
        """Place of a row, which is added if it is new."""
        return self._rows.setdefault(row, len(self._rows))

    def load(self, point: LoadPoint) -> int:
        """Place of a load, which is added if it is new."""
        return self._loads.setdefault((tuple(point.parameters.items()), tuple(point.load.tolist())), len(self._loads))

    def row_entries(self) -> list[RowEntry]:
        """All rows by place."""
        return [RowEntry.model_validate(row.to_json()) for row in self._rows]

    def load_entries(self) -> list[LoadEntry]:
        """All loads by place."""
        return [LoadEntry(parameters=dict(parameters), load=list(load)) for parameters, load in self._loads]


def range_arrays(ranges: Sequence[ScalingRange], tables: Tables) -> Arrays:
    """Arrays of some ranges over the same samples; of the first also the loads that set its ends, if there are any.

    Args:
        ranges: R of them.
        tables: Take up the rows and loads.
    """
    samples = [of.samples for of in ranges]
    bound = [
        [[tables.row(row) for row in of.binding(sample, side)] for sample in range(len(of.samples.time))]
        for of in ranges
        for side in SIDES
    ]
    arrays: Arrays = {
        "status": np.array([[STATUSES.index(status) for status in of.status] for of in samples]),
        "c2_lower": np.array([of.lower for of in samples]),
        "c2_upper": np.array([of.upper for of in samples]),
        "binding_count": np.array([[len(at) for at in end] for end in bound]).reshape(len(ranges), 2, -1),
        "binding_row": np.array([row for end in bound for at in end for row in at], dtype=np.int64),
    }
    lower, upper = samples[0].lower_loads, samples[0].upper_loads
    if lower is not None and upper is not None:
        arrays["end_load"] = np.array([[tables.load(point) for point in end] for end in (lower, upper)])
    return arrays


def conflict_entries(ranges: Sequence[ScalingRange], tables: Tables) -> list[ConflictEntry]:
    """Entries of the infeasible samples of all ranges.

    Args:
        ranges: R of them.
        tables: Take up the rows and loads.
    """
    return [
        ConflictEntry(
            range=number,
            sample=one.sample,
            rows=[tables.row(row) for row in one.rows],
            multipliers=list(one.multipliers),
            widening=one.widening,
            moves=list(one.moves),
            load=None if one.load is None else tables.load(one.load),
            c2=one.c2,
        )
        for number, of in enumerate(ranges)
        for one in of.samples.conflicts
    ]


def read_ranges(path: Path, arrays: Arrays, said: Description, time: Array) -> list[SampleRanges]:
    """The ranges of a saved result.

    Args:
        path: The file, for messages.
        arrays: Of the right shapes.
        said: What the file says of them.
        time: Of the motion, Shape (N,) [s].

    Raises:
        InputError: If a place lies outside what it is a place in.
    """
    rows = [entry.row() for entry in said.rows]
    loads = [LoadPoint(entry.parameters, np.array(entry.load)) for entry in said.loads]
    count, samples = arrays["status"].shape
    binding, chosen = arrays["binding_row"], arrays.get("end_load", np.zeros(0, dtype=np.int64))
    require_places(path, "status", arrays["status"], len(STATUSES))
    require_places(path, "binding_row", binding, len(rows))
    require_places(path, "end_load", chosen, len(loads))
    entries = said.conflicts
    require_places(path, "conflicts: range", [one.range for one in entries], count)
    require_places(path, "conflicts: sample", [one.sample for one in entries], samples)
    require_places(path, "conflicts: rows", [row for one in entries for row in one.rows], len(rows))
    require_places(path, "conflicts: load", [one.load for one in entries if one.load is not None], len(loads))
    counts = np.ravel(arrays["binding_count"])
    codes = np.zeros((len(counts), int(np.max(counts, initial=0))), dtype=np.int32)
    signs = np.array([1 if row.side == "upper" else -1 for row in rows], dtype=np.int32)
    codes[np.arange(codes.shape[1]) < counts[:, None]] = signs[binding] * (1 + binding)
    by_end = codes.reshape(count, 2, samples, codes.shape[1])
    names, limits = tuple(row.name for row in rows), np.tile([row.limit for row in rows], (2, 1))
    conflicts: list[list[Conflict]] = [[] for _ in range(count)]
    for one in entries:
        conflicts[one.range].append(_conflict(one, rows, loads, time))
    found = []
    for number in range(count):
        ends = [tuple(loads[place] for place in end) for end in chosen] if number == 0 else []
        lower_loads, upper_loads = ends or (None, None)
        found.append(
            SampleRanges(
                time=time,
                status=tuple(STATUSES[code] for code in arrays["status"][number]),
                lower=arrays["c2_lower"][number],
                upper=arrays["c2_upper"][number],
                rows=BindingRows(names, limits, by_end[number]),
                conflicts=tuple(conflicts[number]),
                fallbacks=said.range_fallbacks[number],
                lower_loads=lower_loads,
                upper_loads=upper_loads,
                several=said.several[number],
            )
        )
    return found


def rated_entry(found: ScalingRange, tables: Tables) -> RatedEntry | None:
    """What the description says of a range that rates have moved; None if it has no ends.

    Args:
        found: The range.
        tables: Take up the rows and loads.
    """

    def entry(end: RangeEnd) -> EndEntry:
        return EndEntry(
            c2=end.c2 if np.isfinite(end.c2) else None,
            sample=end.sample,
            rows=[tables.row(row) for row in end.rows],
            load=None if end.load is None else tables.load(end.load),
        )

    if found.lower is None or found.upper is None:
        return None
    return RatedEntry(status=found.status, ends=(entry(found.lower), entry(found.upper)))


def read_rated(path: Path, said: Description, samples: SampleRanges) -> ScalingRange:
    """The range over the motion: as rates left it, or the intersection over the samples.

    Args:
        path: The file, for messages.
        said: Its description.
        samples: Its ranges at every sample.

    Raises:
        InputError: If a place does not exist.
    """
    if said.rated is None:
        return intersect(samples)
    rows = [entry.row() for entry in said.rows]
    loads = [LoadPoint(entry.parameters, np.array(entry.load)) for entry in said.loads]

    def end(one: EndEntry) -> RangeEnd:
        for key, places, size in (
            ("sample", [] if one.sample is None else [one.sample], len(samples.time)),
            ("rows", one.rows, len(rows)),
            ("load", [] if one.load is None else [one.load], len(loads)),
        ):
            require_places(path, f"rated: {key}", places, size)
        c2, sample = (np.inf, None) if one.c2 is None else (one.c2, one.sample)
        time = None if sample is None else float(samples.time[sample])
        found = tuple(rows[place] for place in one.rows)
        return RangeEnd(c2, sample, time, found, None if one.load is None else loads[one.load])

    lower, upper = said.rated.ends
    return ScalingRange(said.rated.status, end(lower), end(upper), samples)


def reserve_entry(found: PlanReserve | None, tables: Tables) -> PlanReserveEntry | None:
    """Entry of what is left of the limits; None without a trajectory.

    Args:
        found: What is left.
        tables: Take up the rows and loads.
    """
    if found is None:
        return None

    def entry(one: Reserve) -> ReserveEntry:
        load = None if one.load is None else tables.load(one.load)
        return ReserveEntry(share=one.share, sample=one.sample, rows=[tables.row(row) for row in one.rows], load=load)

    return PlanReserveEntry(whole=entry(found.whole), distributed=found.distributed and entry(found.distributed))


def read_reserve(path: Path, said: Description, time: Array) -> PlanReserve | None:
    """What is left of the limits of a saved result.

    Args:
        path: The file, for messages.
        said: What the file says.
        time: Of the motion, Shape (N,) [s].

    Raises:
        InputError: If a place lies outside what it is a place in.
    """
    if said.reserve is None:
        return None

    def reserve(one: ReserveEntry) -> Reserve:
        require_places(path, "reserve: sample", [one.sample], len(time))
        require_places(path, "reserve: rows", one.rows, len(said.rows))
        require_places(path, "reserve: load", [] if one.load is None else [one.load], len(said.loads))
        rows = tuple(said.rows[place].row() for place in one.rows)
        entry = None if one.load is None else said.loads[one.load]
        load = None if entry is None else LoadPoint(entry.parameters, np.array(entry.load))
        return Reserve(one.share, one.sample, float(time[one.sample]), rows, load)

    distributed = said.reserve.distributed
    return PlanReserve(reserve(said.reserve.whole), None if distributed is None else reserve(distributed))


def require_places(path: Path, key: str, places: Any, size: int) -> None:
    """Check places in a table of a saved result.

    Args:
        path: The file, for the message.
        key: What holds the places.
        places: Of any shape.
        size: Entries of the table.

    Raises:
        InputError: If one is not from 0 to `size` - 1.
    """
    given = np.ravel(np.asarray(places, dtype=np.int64))
    wrong = given[(given < 0) | (given >= size)]
    if wrong.size:
        raise InputError(path, f"must be from 0 to {size - 1}. {DAMAGED}", key=key, value=int(wrong[0]))


def _conflict(entry: ConflictEntry, rows: list[ActiveRow], loads: list[LoadPoint], time: Array) -> Conflict:
    return Conflict(
        sample=entry.sample,
        time=float(time[entry.sample]),
        rows=tuple(rows[place] for place in entry.rows),
        multipliers=tuple(entry.multipliers),
        widening=entry.widening,
        moves=tuple(entry.moves),
        load=None if entry.load is None else loads[entry.load],
        c2=entry.c2,
    )
