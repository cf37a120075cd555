# SPDX-License-Identifier: MIT
"""How an entry of `vary` is spread, as the study file says it."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from mrts.base.errors import InputError
from mrts.base.formats.pose import Finite, Positive
from mrts.base.formats.record import Record, Rule
from mrts.studies.sampling import MOST_STEPS, SampleName
from mrts.studies.spreads import Distribution, Levels, Range, Spread

FORMS = "a list such as [1, 2, 3], a range such as {from: 1, to: 3, steps: 5}, or {normal: {mean: 2, std: 0.1}}"


class NormalDescription(Record):
    """A normal distribution.

    Attributes:
        mean: Its mean.
        std: Its standard deviation.
    """

    mean: Finite
    std: Positive


class LognormalDescription(Record):
    """A distribution of which the logarithm is normal.

    Attributes:
        median: Half of all values are below it.
        log_std: Standard deviation of the natural logarithm.
    """

    median: Positive
    log_std: Annotated[float, Rule(gt=0, le=10, allow_inf_nan=False)]


class UniformDescription(Record):
    """Every value from one to another, one as likely as another.

    Attributes:
        from_: The least value.
        to: The largest.
    """

    from_: Finite
    to: Finite


class TriangularDescription(UniformDescription):
    """A distribution that rises to its likeliest value and falls from there.

    Attributes:
        peak: The likeliest value.
    """

    peak: Finite


class KnobDescription(Record):
    """An entry of `vary` that is no list; see docs/study_file.md.

    Attributes:
        from_: Where a range begins.
        to: Where it ends.
        steps: Of a range, in a grid.
        values: Some values.
        normal, lognormal, uniform, triangular: Distributions.
        sets, shifts, scales: Numbers that a knob moves; an entry without them, (), is itself the path to one.
    """

    from_: Finite | None = None
    to: Finite | None = None
    steps: Annotated[int, Rule(ge=2, le=MOST_STEPS)] | None = None
    values: Annotated[list[Finite], Rule(min_length=1)] | None = None
    normal: NormalDescription | None = None
    lognormal: LognormalDescription | None = None
    uniform: UniformDescription | None = None
    triangular: TriangularDescription | None = None
    sets: Any = ()
    shifts: Any = ()
    scales: Any = ()

    def problem(self) -> str:
        """The rule that its keys break with each other; empty if none."""
        ends = [name for name, value in (("from", self.from_), ("to", self.to)) if value is not None]
        forms = ["a range"] if ends or self.steps is not None else []
        forms += [
            name
            for name in ("values", "normal", "lognormal", "uniform", "triangular")
            if getattr(self, name) is not None
        ]
        if len(forms) != 1:
            given = f"here are {', '.join(forms)}" if forms else "here is none of them"
            return f"one way to vary it belongs here: {FORMS}; {given}"
        if forms == ["a range"] and len(ends) < 2:  # noqa: PLR2004 (both ends)
            return f"a range needs 'from' and 'to'; here is {ends[0] if ends else 'steps alone'}"
        return ""


def read_knob(path: Path, key: str, value: object) -> KnobDescription:
    """An entry of `vary`.

    Args:
        path: The study file, for messages.
        key: Of the entry, likewise.
        value: What stands there.

    Raises:
        InputError: If it breaks a rule.
    """
    if isinstance(value, list):
        value = {"values": value}
    if not isinstance(value, dict):
        raise InputError(path, f"must say how it varies: {FORMS}.", key=key, value=value)
    try:
        return KnobDescription.read(path, value)
    except InputError as error:
        inside = f"{key}.{error.key}" if error.key else key
        raise InputError(path, error.rule, key=inside, value=error.value) from None


def knob_spread(path: Path, key: str, knob: KnobDescription, sample: SampleName) -> Spread:
    """How an entry is spread.

    Args:
        path: The study file, for messages.
        key: Of the entry, likewise.
        knob: The entry.
        sample: How the points of the study are chosen.

    Raises:
        InputError: If a value breaks a rule, or does not go with how points are chosen.
    """
    if knob.values is not None:
        repeated = [value for value in knob.values if knob.values.count(value) > 1]
        if repeated:
            raise InputError(path, "stands twice; each value belongs here once.", key=key, value=repeated[0])
        return Levels(tuple(map(float, knob.values)))
    spread = _continuous(path, key, knob)
    if sample != "grid":
        if knob.steps is not None:
            rule = f"steps are those of a grid; sample: {sample} draws from the whole range. Leave this out."
            raise InputError(path, rule, key=f"{key}.steps", value=knob.steps)
        return spread
    if isinstance(spread, Distribution):
        rule = f"a {spread.kind} distribution has no steps to make a grid of. Take sample: sobol or lhs with a count."
        raise InputError(path, rule, key=key)
    if knob.steps is None:
        rule = "a grid needs to know in how many steps, such as steps: 5. Or take sample: sobol or lhs with a count."
        raise InputError(path, rule, key=key)
    return Levels(tuple(np.linspace(spread.low, spread.high, knob.steps).tolist()), between=True)


def _continuous(path: Path, key: str, knob: KnobDescription) -> Range | Distribution:
    """A range or a distribution."""
    if knob.normal is not None:
        return Distribution("normal", (knob.normal.mean, knob.normal.std))
    if knob.lognormal is not None:
        return Distribution("lognormal", (knob.lognormal.median, knob.lognormal.log_std))
    kind = "uniform" if knob.uniform is not None else "triangular" if knob.triangular is not None else ""
    key = f"{key}.{kind}" if kind else key
    ends = knob.uniform or knob.triangular or knob
    low, high = ends.from_, ends.to
    assert low is not None and high is not None  # noqa: S101, PT018 (checked by the record)
    if not low < high:
        raise InputError(path, "'from' must be below 'to'.", key=key, value={"from": low, "to": high})
    if isinstance(ends, TriangularDescription):
        if not low <= ends.peak <= high:
            raise InputError(path, "must lie between 'from' and 'to'.", key=f"{key}.peak", value=ends.peak)
        return Distribution("triangular", (low, ends.peak, high))
    return Range(float(low), float(high))
