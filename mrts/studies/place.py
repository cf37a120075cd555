# SPDX-License-Identifier: MIT
"""The best layout of a study: a small sweep for starts, steps of linear programs from the best of them.

What a program promises counts only as far as `scale` then says that the cell does it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, linprog
from scipy.sparse import block_diag, csr_array, hstack

from mrts.base.argument_types import Progress, check_callable, check_type
from mrts.base.arrays import Array, apply
from mrts.base.errors import InputError, MotionError, MrtsError, SolverError
from mrts.base.held_interrupt import held_interrupt
from mrts.cell.number_paths import value_at
from mrts.collisions.clearance import clearance_remarks
from mrts.following.coordinate import coordinate
from mrts.motion.object_motion import ObjectMotion
from mrts.program.between_samples import BETWEEN, checked_tolerance
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.scaling.result import ScalingResult
from mrts.scaling.scale import scale
from mrts.studies.placement import NO_GAIN, Placement, PlayedLayout
from mrts.studies.sampling import Distribution, sample_points
from mrts.studies.study import Study, read_study

STARTS = 3
"""Layouts from which a search begins, the best of those that were looked at."""

LOOKED_AT = 64
"""Layouts that are looked at for starts."""

MAX_LAYOUTS = 100_000
"""That may be: an hour of looking."""

SEED = 17

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

OTHER_POSITIONS = 1e-2
"""Share of c²⁺ by which a layout that does worse than promised may do so because arms took other joint positions."""

POSTURE_DIGITS = 4
"""Decimals of a posture that is written to keep joint positions; it only says near which to start."""

NOT_A_LAYOUT = (
    "is no number of a layout. What mrts place moves are base, grasp and posture of robots; leave it out, or compare "
    "its values by mrts sweep."
)


BestChange = Callable[[Array, Array], tuple[Array, float, Array]]
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
        What gives, between bounds of each number, Shape (P,), the best change, c²⁺ that the program has there, and its
        slope ∂ ln c²⁺/∂θ by its multipliers, each Shape (P,): of several rows that bind alike, those are weighed so
        that it vanishes for what is at no bound.

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

    def best_change(lower: Array, upper: Array) -> tuple[Array, float, Array]:
        found = solved(by_layout, np.stack([lower, upper], axis=1))
        return found.x[-len(lower) :], float(found.x[0]), found.ineqlin.marginals @ by_layout / c2

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
    gives. From the best of them steps of linear programs (`layout_program`) lead to the nearest
    local optimum; each counts only as `mrts.scale` confirms it, so the answer is never worse than the best start.
    Layouts in which bodies collide (`mrts.clearance`) are no answer. Ctrl-C keeps the best so far.

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
        counts = search.run(starts, looked_at, progress)
        interrupted = search.over()
        pressed.clear()
    progress(looked_at + starts, looked_at + starts)
    after = search.best_played()
    return Placement(
        study=search.study,
        before=None if search.given is None else search.played(search.given),
        after=after,
        reason=search.failures[-1] if search.failures else "",
        interrupted=interrupted,
        colliding=search.colliding,
        **counts,
    )


class LayoutSearch:
    """Tries layouts of a study and improves them.

    Attributes:
        given: What the cell can do as its file has it; None if it can do nothing.
        found: All layouts that can be played at the samples; why others cannot say `failures`.
        colliding: How many were the fastest, but for a collision.
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
        self.colliding = 0
        self.machines = self.study.cell_of(self.study.cell).machines
        self.as_given, is_layout = _nearest_given(study)
        self.given = self._scaled(self.study.cell, self.as_given, None)
        if self.given is not None and is_layout:
            self.found.append(self.given)

    def run(self, starts: int, looked_at: int, progress: Progress) -> dict[str, int]:
        """Look at layouts, and search from the best; counts those looked at, those playable, and the searches."""
        counts = {"looked_at": 0, "playable": 0, "searches": 0}
        bounds = zip(self.lower, self.upper, strict=True)
        points = sample_points([Distribution("uniform", pair) for pair in bounds], "sobol", SEED, (0, looked_at))
        for values in self._rounded(points):
            if self.over():
                break
            progress(counts["looked_at"], looked_at + starts)
            counts["looked_at"] += 1
            tried = self.tried(values)
            if tried is not None:
                counts["playable"] += 1
                self.found.append(tried)
        for start in sorted(self.found, key=lambda one: -one.c2)[:starts]:
            if self.over():
                break
            progress(looked_at + counts["searches"], looked_at + starts)
            counts["searches"] += 1
            self.improve(start)
        return counts

    def tried(self, values: Array, postures: dict[str, list[float]] | None = None) -> PlayedLayout | None:
        """What the cell can do at values, Shape (P,), with postures in place of the study's; None if nothing."""
        return self._scaled(self._keys(values, postures), values, postures)

    def _keys(self, values: Array, postures: dict[str, list[float]] | None) -> dict[str, Any]:
        keys = self.study.descriptions(values)[0]
        for robot in keys["robots"]:
            robot["posture"] = (postures or {}).get(robot["name"], robot["posture"])
        return keys

    def _rounded(self, values: Array) -> Array:
        """Values as they are written, within their bounds and at a bound that they round to, Shape (…, P)."""
        rounded = np.clip(np.round(values, DIGITS) + 0.0, self.lower, self.upper)
        for bound in (self.lower, self.upper):
            rounded = np.where(np.abs(values - bound) < 10.0**-DIGITS / 2, bound, rounded)
        return rounded

    def _scaled(
        self, keys: dict[str, Any], values: Array, postures: dict[str, list[float]] | None
    ) -> PlayedLayout | None:
        asked = self.study.question
        try:
            cell = self.study.cell_of(keys)
            parted = set(self.machines) - set(cell.machines)
            if parted:
                rule = "robots '{}' and '{}' are arms of one machine: their bases move together. Let one parameter "
                raise MotionError(f"{rule}move both.".format(*min(parted)))
            result = _with_trajectory(scale(cell, self.motion, load=asked.load, reserve=asked.reserve, between=None))
        except MrtsError as error:
            self.failures.append(str(error))
            return None
        return PlayedLayout(keys, values, None, result, postures)

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
                change, promised, slope = program(lower - best.values, upper - best.values)
            except MrtsError as error:  # arms do not follow in a layout beside it, or no solver answers
                self.failures.append(str(error))
                break
            best = replace(best, slope=slope)
            if promised < best.c2 * (1 + WORTH_A_STEP):
                break
            reached = self._reached(best, self._rounded(best.values + change), promised)
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
            cell = self.study.cell_of(self._keys(values, layout.postures))
            cell = cell if self.study.question.reserve is None else cell.with_reserve(self.study.question.reserve)
            rows = motion_rows(cell, coordinate(cell, self.motion))
            loads = [None if point is None else point.load for point in result.loads]
            return [build_sample_problem(rows, load=load, samples=near) for load in loads]

        steps = np.where(layout.values + DIFFERENCE > self.upper, -DIFFERENCE, DIFFERENCE)
        beside = [problems(layout.values + step) for step in np.diag(steps)]
        return layout_program(problems(layout.values), beside, steps, layout.c2)

    def _reached(self, start: PlayedLayout, values: Array, promised: float) -> PlayedLayout | None:
        """What the cell does in a layout; None where it can do nothing.

        Where its postures lead the arms elsewhere than in the program, these are the first joint positions there.
        """
        reached = self.tried(values, start.postures)
        if reached is None or reached.c2 < promised * (1 - OTHER_POSITIONS):
            q, parts = start.result.motion.q[0], start.result.cell.joint_slices.items()
            again = self.tried(values, {name: np.round(q[part], POSTURE_DIGITS).tolist() for name, part in parts})
            if again is not None and (reached is None or again.c2 > reached.c2 * (1 + OTHER_POSITIONS)):
                return again
        return reached

    def best_played(self) -> PlayedLayout | None:
        """The best, and the best start, which might be better between the samples, less what moved for nothing."""
        best_first = sorted(self.found, key=lambda one: -one.c2)
        groups = best_first, [one for one in best_first if one.slope is None]
        played = (next(filter(None, (self._free(self._settled(one)) for one in group)), None) for group in groups)
        return max(filter(None, played), key=lambda layout: layout.c2, default=None)

    def _settled(self, best: PlayedLayout) -> PlayedLayout:
        """The same with every number that gains nothing where the cell file has it."""
        for place, value in enumerate(self.as_given):
            moved = np.where(np.arange(len(self.as_given)) == place, value, best.values)
            if moved[place] != best.values[place]:
                tried = self.tried(moved, best.postures)
                if tried is not None and tried.c2 >= best.c2 * (1 - NO_GAIN):
                    best = replace(tried, slope=best.slope)
        return best

    def _free(self, layout: PlayedLayout) -> PlayedLayout | None:
        """As `played`; None too if two bodies collide."""
        played = self.played(layout)
        if played is None:
            return None
        near, said = clearance_remarks(played.result.cell, played.result.motion)
        if near is not None and near.collides:
            self.failures.append(near.sentence())
            self.colliding += 1
            return None
        return replace(played, collisions=said)

    def played(self, layout: PlayedLayout) -> PlayedLayout | None:
        """A layout between the samples too; None if it cannot be played there."""
        cell, load = layout.result.cell, self.study.question.load
        try:
            result = _with_trajectory(scale(cell, self.motion, load=load, between=self.between))
        except MrtsError as error:
            self.failures.append(str(error))
            return None
        return replace(layout, result=result)


def _with_trajectory(result: ScalingResult) -> ScalingResult:
    if result.trajectory is None:
        raise MotionError(f"{result.status.value}: {result.explanation()}")
    return result


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
