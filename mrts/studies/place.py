# SPDX-License-Identifier: MIT
"""The best layout of a study: a small sweep for starts, steps of linear programs from the best of them.

What a program promises counts only as far as `scale` then says that the cell does it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, linprog
from scipy.sparse import block_diag, csr_array, hstack

from mrts.base.arrays import Array, apply
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import (
    InputError,
    MotionError,
    MrtsError,
    Progress,
    Remark,
    SolverError,
    as_path,
    check_callable,
    check_type,
    printable,
)
from mrts.base.held_interrupt import held_interrupt
from mrts.base.words import aligned
from mrts.cell.cell_keys import value_at
from mrts.following.clearance import clearance_remarks
from mrts.following.coordinate import coordinate
from mrts.motion.object_motion import ObjectMotion
from mrts.program.between_samples import BETWEEN, checked_tolerance
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.scaling.scale import ScalingResult, kept_text, scale
from mrts.studies.parameters import Distribution, sample_points
from mrts.studies.study import Study, read_study

STARTS = 3
"""Layouts from which a search begins, the best of those that were looked at."""

LOOKED_AT = 64
"""Layouts that are looked at for starts."""

MAX_LAYOUTS = 100_000
"""That may be: an hour of looking."""

SEED = 17

NO_GAIN = 1e-9
"""Share of c²⁺ that is no reason to move an arm: rounding."""

DIGITS = 5
"""Decimals of the numbers of an answer: 10 µm and 10 µrad, less than anyone can set up."""

SAME_PLACE = 1e-9
"""Largest difference of numbers that are the same [m, rad]."""

DIFFERENCE = 1e-6
"""Step in a number by which changes of rows are read off [m, rad]: their error is of its size, and rounding 1e-6."""

NEAR = 2.0
"""Samples whose own c²⁺ is up to this many times that of the motion are in the program: no step raises it as far."""

FIRST_REACH, LEAST_REACH = 0.25, 1e-4
"""How far a step may change a number, as a share of its range: at first, and where the search ends."""

MAX_STEPS = 60
"""From one start; ten to thirty are usual."""

WORTH_A_STEP = 1e-6
"""Share of c²⁺ that a program must promise."""

KEPT_PROMISE = 0.5
"""Share of a promise which a step that may go further keeps."""

NO_EFFECT = 1e-3
"""Shares of limits per m or rad below which a number changes no row: what rounding leaves of a posture, which only says
near which joint positions to start. Such a number stays, or it would lead the arms elsewhere for nothing."""

NOT_A_LAYOUT = (
    "is no number of a layout. What mrts place moves are base, grasp and posture of robots; leave it out, or compare "
    "its values by mrts sweep."
)


@dataclass(frozen=True, eq=False, repr=False)
class PlayedLayout:
    """One layout and what the cell does in it.

    Attributes:
        keys: Keys and values of its cell file.
        values: Of the numbers of the study, Shape (P,): those of the cell file, where no values give that, the nearest.
        result: What `mrts.scale` finds, between the samples too.
        collisions: What is to say of them.
    """

    keys: dict[str, Any]
    values: Array
    result: ScalingResult
    collisions: tuple[Remark, ...] = ()

    @property
    def c2(self) -> float:
        """c²⁺; infinity if nothing limits it."""
        return self.result.range.c2_upper

    @property
    def duration(self) -> float:
        """Of the motion at the fastest constant factor [s]; 0 if nothing limits it."""
        return float(self.result.motion.object.time[-1] / np.sqrt(self.c2))


@dataclass(frozen=True, eq=False, repr=False)
class Placement:
    """The best layout of a study.

    Attributes:
        study: The study.
        before: The layout of the cell file; None if it cannot be played.
        after: The best layout within the bounds; None if none that was looked at can be played.
        reason: Why a layout that was looked at cannot be played; empty if all can.
        interrupted: Whether Ctrl-C ended the search early.
    """

    study: Study
    before: PlayedLayout | None
    after: PlayedLayout | None
    reason: str
    interrupted: bool

    def __repr__(self) -> str:
        return f"<Placement: {self.sentence()}>"

    @property
    def gain(self) -> float:
        """Share by which c²⁺ grew; nan where there is no before or after, or nothing limits both."""
        if self.before is None or self.after is None or np.isinf(self.before.c2):
            return float("nan")
        return self.after.c2 / self.before.c2 - 1

    def sentence(self) -> str:
        """The outcome."""
        after, before = self.after, self.before
        name = f"{self.study.cell['name']}: {kept_text(self.study.question.reserve or 0)}".rstrip()
        if after is None:
            return f"{name} no layout that was looked at can be played. {self.reason}"
        if before is None:
            return (
                f"{name} c² up to {after.c2:.4g}, {after.duration:.4g} s; the layout of the cell file cannot be played"
            )
        if after.c2 <= before.c2 * (1 + NO_GAIN):
            return f"{name} no layout was found that is better than that of the cell file, c² up to {before.c2:.4g}"
        return (
            f"{name} c² up to {after.c2:.4g} instead of {before.c2:.4g} ({100 * self.gain:+.1f} %), "
            f"{after.duration:.4g} s instead of {before.duration:.4g} s"
        )

    def lines(self) -> Iterator[str]:
        """What the command line says: the outcome, what binds, and what moved."""
        yield self.sentence()
        after, before = self.after, self.before
        if after is None:
            return
        for word, layout in (("limited", after), ("before", before)):
            if layout is not None and (end := layout.result.range.upper).time is not None:
                yield f"{word} {end.place()}"
        yield ""
        rows = [("what may move", "before", "after", "")]
        for path, unit, was, value in self.moved():
            rows.append((path, f"{was:.6g}", "stays" if value == was else f"{value:.6g}", unit))
        yield from aligned(rows)
        yield ""
        yield from (remark.text for remark in after.collisions)

    def moved(self) -> list[tuple[str, str, float, float]]:
        """Path, unit, value before and after of each number that the study sets."""
        assert self.after is not None  # noqa: S101 (asked for of an answer only)
        ours, theirs = ({"cell": keys} for keys in (self.study.cell, self.after.keys))
        targets = [target for parameter in self.study.parameters for target in parameter.targets]
        return [
            (target.path, target.unit, float(value_at(ours, target.keys)), float(value_at(theirs, target.keys)))
            for target in targets
        ]

    def write(self, path: Path | str) -> None:
        """Write the cell file of the best layout, whole or not at all; comments of the study's own are not in it.

        Args:
            path: The file.

        Raises:
            InputError: If there is no such layout, or the file cannot be written.
        """
        path = as_path("path", path)
        if self.after is None:
            raise InputError(path, "there is no layout to write: none within the bounds can be played.")
        heading = f"# The layout that mrts place found of {printable(self.study.path.name)}\n"
        write_text_atomically(path, heading + self.study.cell_text(self.after.keys, path.absolute().parent))


BestChange = Callable[[Array, Array], tuple[Array, float]]
"""Of a program: see `layout_program`."""


def layout_program(
    here: Sequence[SampleProblem], beside: Sequence[Sequence[SampleProblem]], steps: Array, c2: float
) -> BestChange:
    """What a small change of P numbers of a layout does to c²⁺, as a linear program.

    c²⁺ of a layout θ is the largest c² for which wrenches x_k keep the rows A_k(θ) x_k + a_k(θ) c² + b_k(θ) c <= u_k(θ)
    of all samples. With rows that are linear in a change of θ it is found together with the best change inside a box: a
    step of sequential linear programming (Griffith and Stewart, 1961). How rows change is read off at layouts beside
    this one, so that whatever limits a cell is searched with.

    Args:
        here: Its rows at N samples, a problem for each load that must be carried.
        beside: The same problems of layouts in each of which one number is larger.
        steps: By how much, Shape (P,); below 0 it is smaller.
        c2: c²⁺ here.

    Returns:
        What gives, between bounds of each number, Shape (P,), the best change, Shape (P,), and c²⁺ that the program has
        there.

    Raises:
        SolverError: If HiGHS does not solve it, also by what it gives.
    """
    A, speed, limit = _one_sided(here)
    kept, c = np.isfinite(limit), np.sqrt(c2)
    wrenches = block_diag([of[rows, :-1] for of, rows in zip(A, kept, strict=True)])
    square = A[:, :, -1] + speed / (2 * c)  # c is linear in c² near c²⁺
    matrix = hstack([csr_array(square[kept][:, None]), wrenches], format="csr")
    largest = (limit - speed * c / 2)[kept]

    def solved(by_layout: Array, bounds: Array) -> OptimizeResult:
        free = [(None, None)] * matrix.shape[1]
        found = linprog(
            -np.eye(1, len(free) + len(bounds))[0],
            A_ub=hstack([matrix, csr_array(by_layout)], format="csr"),
            b_ub=largest,
            bounds=[*free, *bounds.tolist()],
        )
        if found.x is None:
            raise SolverError(f"HiGHS finds no change of the layout: {found.message}")
        return found

    found = solved(np.zeros((len(largest), 0)), np.zeros((0, 2)))
    x = np.append(found.x[1:].reshape(len(A), -1), np.full((len(A), 1), c2), axis=1)

    def beyond(problems: Sequence[SampleProblem]) -> Array:
        A, speed, limit = _one_sided(problems)
        over: Array = apply(A, x) + speed * c - limit
        return over[kept]

    by_layout = np.stack([beyond(problems) - beyond(here) for problems in beside], axis=1) / steps
    has_effect = np.max(np.abs(by_layout), axis=0, initial=0.0) > NO_EFFECT

    def best_change(lower: Array, upper: Array) -> tuple[Array, float]:
        found = solved(by_layout, np.stack([lower, upper], axis=1) * has_effect[:, None])
        return found.x[-len(lower) :], float(found.x[0])

    return best_change


def _one_sided(problems: Sequence[SampleProblem]) -> tuple[Array, Array, Array]:
    """Both sides of the rows of all problems as A x + b c <= u: A, Shape (S, 2 r, k), b and u, Shape (S, 2 r)."""
    sides = [
        (np.concatenate([of.A, -of.A], axis=1), np.zeros_like(of.lower) if of.speed is None else of.speed,
         np.concatenate([of.upper, -of.lower], axis=1))
        for of in problems
    ]  # fmt: skip
    A, speed, limit = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    return A, np.concatenate([speed, -speed], axis=1), limit


def place(
    study: Study | Path | str,
    *,
    starts: int = STARTS,
    looked_at: int = LOOKED_AT,
    between: float | None = BETWEEN,
    progress: Progress = lambda _done, _total: None,
) -> Placement:
    """Base poses, grasps and postures, within the bounds of a study, that give the largest c²⁺.

    The layouts looked at first are points of a Sobol sequence between the bounds, and the layout that the cell file
    gives. From the best of them steps of linear programs (`layout_program`) lead to the nearest local optimum; each
    counts only as `mrts.scale` confirms it, so the answer is never worse than that of the cell file. Layouts in which
    bodies collide (`mrts.clearance`) are no answer. Ctrl-C keeps the best so far.

    Args:
        study: The study, or its file; `vary` names numbers of base, grasp or posture, each `from` and `to`.
        starts: From how many layouts to search.
        looked_at: Of how many.
        between: Share of a limit by which it may be overstepped between the samples, as in `mrts.scale`, before and
            after; the search itself looks at samples alone.
        progress: Told how many of how many pieces of work are done.

    Returns:
        The outcome. Where no layout within the bounds can be played, it has no answer.

    Raises:
        InputError: If the study varies what is no layout, or asks what does not fit.
        SolverError: If no solver answers.
    """
    if not isinstance(study, Study):
        study = read_study(study)
    for name, value in (("starts", starts), ("looked_at", looked_at)):
        check_type(name, value, int)
        if not 1 <= value <= MAX_LAYOUTS:
            raise InputError(name, f"must be at least 1, and at most {MAX_LAYOUTS}.", value=value)
    check_callable("progress", progress)
    tolerance = checked_tolerance(between)
    if study.question.load == "possible":
        rule = "the best layout is one for loads that are known, or for every load of a box: nominal or guaranteed."
        raise InputError(study.path, rule, key="load", value="possible")
    search = LayoutSearch(study, tolerance)
    with held_interrupt() as pressed:
        search.over = lambda: bool(pressed)
        search.run(starts, looked_at, progress)
        interrupted = search.over()
        pressed.clear()
    progress(looked_at + starts, looked_at + starts)
    before = None if search.given is None else search.played(search.given)
    return Placement(
        study=search.study,
        before=before,
        after=search.best_played(),
        reason=search.failures[-1] if search.failures else "",
        interrupted=interrupted,
    )


class LayoutSearch:
    """Tries layouts of a study and improves them.

    Attributes:
        given: What the cell can do as its file has it; None if it can do nothing.
        found: All layouts that can be played at the samples; why others cannot say `failures`.
        over: Says whether to come to the end.
    """

    def __init__(self, study: Study, between: float | None = None) -> None:
        self.study, self.between = study.at_hand(), between
        self.lower, self.upper = layout_bounds(study)
        self.motion = study.motion_of(study.motion)
        if not isinstance(self.motion, ObjectMotion):
            rule = "a table of joint motion fixes where the arms stand; give the object's motion."
            raise InputError(study.path, rule, key="motion")
        self.over: Callable[[], bool] = lambda: False
        self.found: list[PlayedLayout] = []
        self.failures: list[str] = []
        self.machines = self.study.cell_of(self.study.cell).machines
        self.as_given, is_layout = _nearest_given(study)
        self.given = self._scaled(self.study.cell, self.as_given)
        if self.given is not None and is_layout:
            self.found.append(self.given)

    def run(self, starts: int, looked_at: int, progress: Progress) -> None:
        """Look at layouts, and search from the best."""
        bounds = zip(self.lower, self.upper, strict=True)
        points = sample_points([Distribution("uniform", pair) for pair in bounds], "sobol", SEED, (0, looked_at))
        for number, values in enumerate(self._rounded(points)):
            if self.over():
                return
            progress(number, looked_at + starts)
            tried = self.tried(values)
            if tried is not None:
                self.found.append(tried)
        for number, start in enumerate(sorted(self.found, key=lambda one: -one.c2)[:starts]):
            if self.over():
                return
            progress(looked_at + number, looked_at + starts)
            self.improve(start)

    def tried(self, values: Array) -> PlayedLayout | None:
        """What the cell can do at values, Shape (P,); None if nothing."""
        return self._scaled(self.study.descriptions(values)[0], values)

    def _rounded(self, values: Array) -> Array:
        """Values as they are written, within their bounds and at a bound that they round to, Shape (…, P)."""
        rounded = np.clip(np.round(values, DIGITS) + 0.0, self.lower, self.upper)
        for bound in (self.lower, self.upper):
            rounded = np.where(np.abs(values - bound) < 10.0**-DIGITS / 2, bound, rounded)
        return rounded

    def _scaled(self, keys: dict[str, Any], values: Array, between: float | None = None) -> PlayedLayout | None:
        try:
            cell = self.study.cell_of(keys)
            parted = set(self.machines) - set(cell.machines)
            if parted:
                rule = "robots '{}' and '{}' are arms of one machine: their bases move together. Let one parameter "
                raise MotionError(f"{rule}move both.".format(*min(parted)))
            result = scale(cell, self.motion, load=self.study.question.load, between=between)
            if result.trajectory is None:
                raise MotionError(result.sentence())
        except MrtsError as error:
            self.failures.append(str(error))
            return None
        return PlayedLayout(keys, values, result)

    def improve(self, start: PlayedLayout) -> None:
        """Search from a layout; what the cell can play on the way joins those that were found."""
        best, reach, program = start, FIRST_REACH, None
        for _ in range(MAX_STEPS):
            if self.over() or reach < LEAST_REACH or not np.isfinite(best.c2):
                break
            far = reach * (self.upper - self.lower)
            lower, upper = (np.clip(best.values + side, self.lower, self.upper) for side in (-far, far))
            try:
                program = program or self.program(best)
                change, promised = program(lower - best.values, upper - best.values)
            except MrtsError as error:  # arms do not follow in a layout beside it, or no solver answers
                self.failures.append(str(error))
                break
            if promised < best.c2 * (1 + WORTH_A_STEP):
                break
            reached = self.tried(self._rounded(best.values + change))
            gain = -1.0 if reached is None else (reached.c2 - best.c2) / (promised - best.c2)
            reach *= 2.0 if gain > KEPT_PROMISE else 0.5 if gain > 0 else 0.25
            if reached is not None and gain > 0:
                self.found.append(best)
                best, program = reached, None
        self.found.append(best)

    def program(self, layout: PlayedLayout) -> BestChange:
        """The program of a layout that can be played.

        Raises:
            MotionError: If the arms cannot follow in a layout beside it.
            SolverError: If the program is not solved.
        """
        result = layout.result
        near = np.flatnonzero(result.range.samples.upper <= NEAR * layout.c2)

        def problems(values: Array) -> list[SampleProblem]:
            cell = self.study.cell_of(self.study.descriptions(values)[0])
            rows = motion_rows(cell, coordinate(cell, self.motion))
            loads = [None if point is None else point.load for point in result.loads]
            return [build_sample_problem(rows, load=load, samples=near) for load in loads]

        steps = np.where(layout.values + DIFFERENCE > self.upper, -DIFFERENCE, DIFFERENCE)
        beside = [problems(layout.values + step) for step in np.diag(steps)]
        return layout_program(problems(layout.values), beside, steps, layout.c2)

    def best_played(self) -> PlayedLayout | None:
        """The best that can be played between the samples too, less what moved for nothing; or that of the file."""
        best_first = sorted(self.found, key=lambda one: -one.c2)
        groups = map(self._settled, best_first), [one for one in best_first if one is self.given]
        played = (next(filter(None, map(self._free, group)), None) for group in groups)
        return max(filter(None, played), key=lambda layout: layout.c2, default=None)

    def _settled(self, best: PlayedLayout) -> PlayedLayout:
        """The same with every number that gains nothing where the cell file has it."""
        for place, value in enumerate(self.as_given):
            moved = np.where(np.arange(len(self.as_given)) == place, value, best.values)
            if moved[place] != best.values[place]:
                tried = self.tried(moved)
                if tried is not None and tried.c2 >= best.c2 * (1 - NO_GAIN):
                    best = tried
        return best

    def _free(self, layout: PlayedLayout) -> PlayedLayout | None:
        """As `played`; None too if two bodies collide."""
        played = self.played(layout)
        if played is None:
            return None
        near, said = clearance_remarks(played.result.cell, played.result.motion)
        if near is not None and near.collides:
            self.failures.append(near.sentence())
            return None
        return replace(played, collisions=said)

    def played(self, layout: PlayedLayout) -> PlayedLayout | None:
        """A layout between the samples too; None if it cannot be played there."""
        return self._scaled(layout.keys, layout.values, self.between)


def layout_bounds(study: Study) -> tuple[Array, Array]:
    """Least and largest values of the numbers of a study that are a layout, Shape (P,) each.

    Raises:
        InputError: If it varies what is no layout, or not between two values.
    """
    ends = []
    for parameter in study.parameters:
        for target in parameter.targets:
            if target.keys[:2] != ("cell", "robots") or target.keys[3] not in {"base", "grasp", "posture"}:
                raise InputError(study.path, NOT_A_LAYOUT, key=f"vary: {target.path}")
        distribution = parameter.distribution
        if distribution.kind not in {"uniform", "steps"}:
            rule, said = "must be given by 'from' and 'to', between which the best layout is searched.", str(parameter)
            raise InputError(study.path, rule, key=f"vary: {parameter.path}", value=said)
        ends.append((distribution.numbers[0], distribution.numbers[-1]))
    lower, upper = np.array(ends).T
    return lower, upper


def _nearest_given(study: Study) -> tuple[Array, bool]:
    """The values nearest to what the files have, within bounds, Shape (P,), and whether they give just that."""
    files, values, off = {"cell": study.cell}, [], 0.0
    for parameter, low, high in zip(study.parameters, *layout_bounds(study), strict=True):
        factor, offset = np.array([(target.factor, target.offset) for target in parameter.targets]).T
        given = np.array([value_at(files, target.keys) for target in parameter.targets])
        value = np.clip(factor @ (given - offset) / (factor @ factor), low, high)
        off = max(off, float(np.max(np.abs(offset + factor * value - given))))
        values.append(value)
    return np.array(values), off <= SAME_PLACE
