# SPDX-License-Identifier: MIT
"""A result in one file: all that `mrts.scale` found, read again without a compiler; see docs/saved_results.md."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from mrts.base.argument_types import as_path, check_type
from mrts.base.arrays import with_infinity
from mrts.base.atomic_file import write_atomically
from mrts.base.errors import InputError, as_array
from mrts.base.load_box import LoadPoint
from mrts.base.remark import Remark
from mrts.base.version import __version__
from mrts.cell.cell import Cell
from mrts.cell.cell_text import manifest_of
from mrts.cell.functions import CellFunctions, saved_functions
from mrts.cell.loading import cell_from_manifest
from mrts.cell.record import CellManifest
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.row_check import limit_name
from mrts.motion.object_motion import ObjectMotion
from mrts.output.npz_file import open_arrays
from mrts.output.saved_json import (
    DAMAGED,
    DESCRIPTION_BYTES,
    DESCRIPTION_RATIO,
    FORMAT_NAME,
    LARGEST_SAVED,
    VERSION,
    BoxEntry,
    Description,
    ExcessEntry,
    RatesEntry,
    RuleEntry,
    SharingEntry,
    StudyEntry,
    WarningEntry,
    read_description,
)
from mrts.output.saved_ranges import (
    Arrays,
    Tables,
    conflict_entries,
    range_arrays,
    rated_entry,
    read_ranges,
    read_rated,
    read_reserve,
    require_places,
    reserve_entry,
)
from mrts.output.saved_what_if import read_what_if, what_if_entry
from mrts.program.excess import Excess
from mrts.program.load_sharing import LoadSharing
from mrts.program.rate_limits import RateLimits
from mrts.scaling.loads import LoadStudy
from mrts.scaling.options import Options
from mrts.scaling.range import ScalingRange, intersect
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import Holding, ScaledTrajectory

MOTION = ("time", "position", "rotation", "twist", "acceleration")
"""Arrays of the object's motion."""

TRAJECTORY = ("torque", "wrench", "internal_wrench")
"""Arrays that are there if some c² was chosen."""

KNOWN = frozenset(
    {*MOTION, "q", "dq", "ddq", "travel", "status", "c2_lower", "c2_upper", "binding_count", "binding_row", "end_load"}
    | {*TRAJECTORY, "holds", "holding_torque", "holding_wrench"}
)
"""All arrays that a file may hold, beside its description."""

WHOLE_NUMBERS = ("status", "binding_count", "binding_row", "end_load", "holds")
"""Arrays of codes, counts and places in tables."""


def save_result(result: ScalingResult, path: Path | str) -> None:
    """Write a result to a file, whole or not at all; the same result makes the same bytes.

    Args:
        result: The result.
        path: The file to make or replace, by custom NAME.npz.

    Raises:
        InputError: If the file cannot be written, or the result has a c² without torques, as `RetimingResult.factor`.
    """
    check_type("result", result, ScalingResult)
    if result.c2 is not None and result.trajectory is None:
        raise InputError("result", "has a c² without torques: save the timing's 'constant', which has both.")
    path = as_path("path", path)
    motion, done = result.motion, result.trajectory
    ranges = [result.range, *(result.load.ranges if result.load else ())]
    tables = Tables()
    arrays: Arrays = {name: getattr(motion.object, name) for name in MOTION}
    arrays |= {"q": motion.q, "dq": motion.dq, "ddq": motion.ddq} | range_arrays(ranges, tables)
    if motion.travel is not None:
        arrays["travel"] = motion.travel
    if done is not None:
        arrays |= {name: getattr(done, name) for name in TRAJECTORY}
        if done.holding is not None:
            arrays |= {"holds": np.array(done.holding.ends, dtype=np.uint8)}
            arrays |= {"holding_torque": done.holding.torque, "holding_wrench": done.holding.wrench}
    text = _description(result, ranges, tables).text()
    named: dict[str, Any] = arrays | {"description": np.frombuffer(text.encode(), dtype=np.uint8)}

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez_compressed(file, **named)

    write_atomically(path, write)


def load_result(path: Path | str, cell: Cell | None = None) -> ScalingResult:
    """Read a result that `save_result` wrote; nothing in the file is executed.

    Without `cell` everything works that was found and kept; what takes the cell's compiled functions (`residuals`,
    `torques_for_load`, a new `scale`) says so.

    Args:
        path: The file.
        cell: The same cell from `load_cell`: its functions are then at hand, and limits that it was given in Python.
            Those of its file, postures and load do not count; the result keeps those that it was found with.

    Raises:
        InputError: If the file is no saved result, not whole, of a newer version, or of another cell.
    """
    path = as_path("path", path)
    check_type("cell", cell, Cell, NoneType)
    said, arrays = _read(path)
    functions = saved_functions(said.manifest, path) if cell is None else _functions_of(cell, said.manifest, path)
    with _damage(path):
        known = cell_from_manifest(said.manifest, functions, None if cell is None else cell.folder)
    _check_arrays(path, arrays, said, known)
    with _damage(path):
        load_box = None if said.load_box is None else said.load_box.box()
        known = replace(
            known,
            load=np.array(said.load),
            load_box=load_box,
            enforces_velocity_limits=said.enforces_velocity_limits,
            reserve=said.kept_reserve,
            limits=() if cell is None else cell.limits,
        )
        time, position, rotation, twist, acceleration = (arrays[name] for name in MOTION)
        carried = ObjectMotion(time, position, rotation, twist, acceleration, smooth=False)  # it may be a retimed one
        motion = CoordinatedMotion(carried, arrays["q"], arrays["dq"], arrays["ddq"], travel=arrays.get("travel"))
        options = replace(_options(said.rule), load="nominal" if said.study is None else said.study.question)
        box = None if said.study is None else said.study.box.box()
        changes = read_what_if(said.what_if)
    whole, *of_loads = read_ranges(path, arrays, said, motion.object.time)
    first, others = read_rated(path, said, whole), map(intersect, of_loads)
    study = None
    if said.study is not None and box is not None:
        require_places(path, "study.points", said.study.points, len(said.loads))
        entries = [said.loads[place] for place in said.study.points]
        points = tuple(LoadPoint(entry.parameters, np.array(entry.load)) for entry in entries)
        study = LoadStudy(said.study.question, box, points, tuple(others), tuple(said.study.not_converged))
    done = None
    if said.c2 is not None:
        held = None
        if "holds" in arrays:
            start, end = (bool(value) for value in arrays["holds"])
            held = Holding((start, end), arrays["holding_torque"], arrays["holding_wrench"])
        done = ScaledTrajectory(known, motion, said.c2, arrays["torque"], arrays["wrench"], held)
        done = done.with_internal_wrench(arrays["internal_wrench"])
    told = (Remark(one.code, one.text, one.sample, one.severity) for one in said.warnings)
    warnings = (*told, *_other_limits(said.limits, known))
    result = ScalingResult(
        cell=known,
        motion=motion,
        found=first,
        c2=said.c2,
        trajectory=done,
        fallbacks=said.fallbacks,
        load=study,
        options=options,
        origin=said.origin,
        warnings=warnings,
        excess=_excess(path, said),
        changes=changes,
    )
    reserve = read_reserve(path, said, motion.object.time)
    return result if reserve is None and done is not None else result.with_known_reserve(reserve)


def _excess(path: Path, said: Description) -> Excess | None:
    """How far limits are overstepped between the samples."""
    left = said.excess
    if left is None:
        return None
    require_places(path, "excess: row", [] if left.row is None else [left.row], len(said.rows))
    row = None if left.row is None else said.rows[left.row].row()
    return Excess(left.share, left.tolerance, left.time, row)


def _other_limits(found_with: list[str], cell: Cell) -> tuple[Remark, ...]:
    """That a cell was given other limits than the one that the result was found with."""
    given = list(map(limit_name, cell.limits))
    if found_with == given:
        return ()
    text = (
        f"the result was found with a cell with the limits {', '.join(found_with) or 'of its file alone'}, and is read "
        f"with {', '.join(given) or 'no others than those of its file'}: of these it is told how far they are used. "
        "Read it with `cell=` that has the same."
    )
    return (Remark("other-limits", text),)


@contextmanager
def _damage(path: Path) -> Iterator[None]:
    """What a value of the file breaks is told as damage of the file."""
    try:
        yield
    except InputError as error:
        raise InputError(path, f"{error.rule} {DAMAGED}", key=error.where) from None


def _description(result: ScalingResult, ranges: list[ScalingRange], tables: Tables) -> Description:
    """What the file says beside its arrays."""
    cell, rule, study = result.cell, result.options, result.load
    sharing = rule.sharing
    entry = None
    if study is not None:
        entry = StudyEntry(
            question=study.question,
            box=BoxEntry.of(study.box),
            points=[tables.load(point) for point in study.points],
            not_converged=list(study.not_converged),
        )
    conflicts = conflict_entries(ranges, tables)
    reserve = reserve_entry(result.reserve, tables)
    rated = None if rule.rates is None else rated_entry(result.range, tables)
    left, excess = result.excess, None
    if left is not None:
        row = None if left.row is None else tables.row(left.row)
        excess = ExcessEntry(share=left.share, tolerance=left.tolerance, time=left.time, row=row)
    return Description(
        format=FORMAT_NAME,
        version=VERSION,
        mrts_version=__version__,
        manifest=manifest_of(cell),
        load=cell.load.tolist(),
        load_box=None if cell.load_box is None else BoxEntry.of(cell.load_box),
        enforces_velocity_limits=cell.enforces_velocity_limits,
        rule=RuleEntry(
            sharing=None
            if sharing is None
            else SharingEntry(shares=_listed(sharing.shares), internal_wrench=_listed(sharing.internal_wrench)),
            formulation=rule.formulation,
            weights=_listed(rule.weights),
            distribute=rule.distribute,
            rates=None if rule.rates is None else RatesEntry.model_validate(rule.rates.to_json()),
        ),
        c2=None if result.trajectory is None else result.trajectory.c2,
        fallbacks=result.fallbacks,
        several=[of.samples.several for of in ranges],
        range_fallbacks=[of.samples.fallbacks for of in ranges],
        study=entry,
        origin=result.origin,
        warnings=[WarningEntry.model_validate(warning.to_json()) for warning in result.warnings],
        rows=tables.row_entries(),
        limits=list(map(limit_name, cell.limits)),
        loads=tables.load_entries(),
        conflicts=conflicts,
        kept_reserve=cell.reserve,
        reserve=reserve,
        excess=excess,
        rated=rated,
        what_if=what_if_entry(result.changes),
    )


def _listed(values: Any) -> Any:
    return None if values is None else np.asarray(values, dtype=np.float64).tolist()


def _options(entry: RuleEntry) -> Options:
    def array(name: str, values: Any) -> Any:
        return None if values is None else as_array(name, values)

    sharing = entry.sharing
    fixed = None
    if sharing is not None:
        fixed = LoadSharing(array("shares", sharing.shares), array("internal_wrench", sharing.internal_wrench))
    given, rates = entry.rates, None
    if given is not None:
        rates = RateLimits(*(with_infinity(of, np.inf) for of in (given.torque, given.wrench, given.jerk)))
    return Options(
        sharing=fixed,
        formulation=entry.formulation,
        weights=array("weights", entry.weights),
        distribute=entry.distribute,
        rates=rates,
    )


def _functions_of(cell: Cell, saved: CellManifest, path: Path) -> CellFunctions:
    """The functions of a cell if they are those that a result was found with."""
    made = cell.functions.manifest
    ours, theirs = (_made_from(manifest, baked=made.is_baked) for manifest in (made, saved))
    for key in theirs | ours:
        if ours.get(key) != theirs.get(key):
            raise InputError(
                path,
                f"cell '{cell.name}' is another one than the result was found with, '{saved.name}': they differ in "
                f"{key}. Read the cell file that it was found with.",
                key="cell",
            )
    return cell.functions


def _made_from(manifest: CellManifest, *, baked: bool) -> dict[str, Any]:
    """What a cell's functions depend on: not its limits and load, nor, unless it is folded in, its geometry."""
    made: dict[str, Any] = {"plane": manifest.plane, "wrench_components": manifest.wrench_components}
    if baked:
        made["gravity"] = manifest.gravity.tolist()
    for number, robot in enumerate(manifest.robots):
        source = robot.source
        own: dict[str, Any] = {"urdf": source.sha256, "base_link": source.base_link, "tip_link": source.tip_link}
        own |= {"held": dict(robot.held), "name": robot.name}
        if baked:
            own |= {"base": robot.T_world_base.numbers.tolist(), "grasp": robot.T_object_tip.numbers.tolist()}
        made |= {f"robots[{number}].{key}": value for key, value in own.items()}
    return made | {"name": manifest.name}


def _read(path: Path) -> tuple[Description, Arrays]:
    """Description and arrays of a file."""
    with open_arrays(path, "saved result", "`mrts scale CELL MOTION --save FILE.npz` writes one.") as archive:
        if "description" not in archive.names:
            raise InputError(path, "is no saved result of mrts: it holds no array 'description'.")
        most = max(DESCRIPTION_BYTES, DESCRIPTION_RATIO * archive.size)
        said = read_description(path, archive.read("description", most).tobytes())
        names = [name for name in archive.names if name != "description"]
        for name in names:
            if name not in KNOWN:
                raise InputError(path, f"this array does not belong here. {DAMAGED}", key=name)
        return said, {name: archive.read(name) for name in names}


def _check_arrays(path: Path, arrays: Arrays, said: Description, cell: Cell) -> None:
    """Check names, kinds, shapes and numbers of all arrays."""
    ranges = 1 + (len(said.study.points) if said.study else 0)
    if not len(said.range_fallbacks) == len(said.several) == ranges:
        raise InputError(path, f"must have {ranges} values. {DAMAGED}", key="range_fallbacks, several")
    N, m = np.size(arrays.get("time", ())), sum(len(robot.joints) for robot in cell.robots)
    f = len(cell.robots) * len(cell.wrench_components)
    rates = said.rule.rates
    if rates is not None and (len(rates.torque), len(rates.wrench), len(rates.jerk)) != (m, f, m):
        raise InputError(path, f"must have {m}, {f} and {m} values. {DAMAGED}", key="rule.rates")
    shapes: dict[str, tuple[int, ...]] = {"time": (N,), "position": (N, 3), "rotation": (N, 3, 3)}
    shapes |= {"twist": (N, 6), "acceleration": (N, 6), "q": (N, m), "dq": (N, m), "ddq": (N, m)}
    shapes |= {"c2_lower": (ranges, N), "c2_upper": (ranges, N), "status": (ranges, N)}
    shapes |= {"binding_count": (ranges, 2, N), "binding_row": (np.size(arrays.get("binding_row", ())),)}
    shapes |= {name: shape for name, shape in (("end_load", (2, N)), ("travel", (2, N, m))) if name in arrays}
    if said.c2 is not None:
        shapes |= {"torque": (N, m), "wrench": (N, f), "internal_wrench": (N, f)}
        if "holds" in arrays:
            shapes |= {"holds": (2,), "holding_torque": (2, m), "holding_wrench": (2, f)}
    for name in sorted(shapes.keys() ^ arrays.keys()):
        problem = "is missing" if name in shapes else "does not belong here"
        raise InputError(path, f"this array {problem}. {DAMAGED}", key=name)
    for name, shape in shapes.items():
        array, whole = arrays[name], name in WHOLE_NUMBERS
        if array.shape != shape or array.dtype.kind not in ("iu" if whole else "f"):
            kind = "whole numbers" if whole else "numbers"
            raise InputError(path, f"must be {kind} with Shape {shape}. {DAMAGED}", key=name, value=array.shape)
        unlimited = np.isinf(array) if name.startswith("c2_") else False
        bad = ~((np.abs(array) <= LARGEST_SAVED) | unlimited)
        if np.any(bad):
            rule = f"must be finite numbers, at most {LARGEST_SAVED:.0e} in size. {DAMAGED}"
            raise InputError(path, rule, key=name, value=float(array[bad][0]))
    require_places(path, "binding_count", arrays["binding_count"], len(said.rows) + 1)
    bound = int(np.sum(arrays["binding_count"]))
    if bound != len(arrays["binding_row"]):
        raise InputError(path, f"must have Shape ({bound},), the sum of binding_count. {DAMAGED}", key="binding_row")
