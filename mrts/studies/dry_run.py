# SPDX-License-Identifier: MIT
"""What a study will do and how long it will take, told before it starts."""

import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from mrts.base.argument_types import check_type
from mrts.studies.study import Study
from mrts.studies.variant_rows import solve_variants

ENOUGH = 0.5
"""Time that the block takes by which the others are judged [s], unless the whole study takes less."""

GROWTH = 4
"""How many times as many variants the next block has."""

GOLDEN = 0.6180339887498949
"""Share of the study by which the next block lies further on: blocks meet all parts of it alike."""

UNITS_OF_TIME = (("s", 1.0), ("min", 60.0), ("h", 3600.0), ("days", 86400.0))


@dataclass(frozen=True)
class StudyEstimate:
    """How long a study will take, from solving a few of its variants.

    Attributes:
        study: The study.
        tried: Number of variants that were solved for it.
        statuses: How many of them have each status.
        seconds_each: Time that one takes on one core [s].
        reason: Why one of them is not feasible; empty if all are.
    """

    study: Study
    tried: int
    statuses: dict[str, int]
    seconds_each: float
    reason: str = ""

    def seconds(self, workers: int = 1) -> float:
        """Time that the whole study takes with so many workers, each with a core of its own [s]."""
        return self.seconds_each * self.study.variants / workers

    def lines(self, workers: int = 1) -> Iterator[str]:
        """What the study varies and asks, and how long it will take, for people."""
        yield from study_lines(self.study)
        found = ", ".join(f"{number} {status}" for status, number in sorted(self.statuses.items()))
        each = self.seconds_each
        rate = f"{1 / each:.0f} a second" if each < 1 else f"{each:.3g} s each"
        cores = "one core" if workers == 1 else f"{workers} cores"
        yield f"tried {self.tried} ({found}): {rate}, so about {time_text(self.seconds(workers))} on {cores}"
        if self.reason:
            yield f"  such as {self.reason}"


def study_lines(study: Study) -> Iterator[str]:
    """What a study varies and asks, for people."""
    drawn = "" if study.sample == "grid" else f", seed {study.seed}"
    yield f"{study.path.name}: {study.variants} variants ({study.sample}{drawn}) of cell '{study.cell['name']}'"
    for parameter in study.parameters:
        yield f"  {parameter}"
    question = study.question
    asked = [f"{name} {value}" for name, value in question if name != "between" and value not in {None, False}]
    samples = "at the samples alone" if question.between is None else f"between the samples to {question.between:g}"
    yield f"asked of each: {', '.join(asked)}, {samples}"


def estimate(study: Study) -> StudyEstimate:
    """How long a study will take on one core: a few of its variants are solved, more until their time can be told.

    Raises:
        InputError: If it is no study.
    """
    check_type("study", study, Study)
    size, place = 1, 0.0
    while True:
        first = int((study.variants - size) * place)
        start = time.perf_counter()
        rows = solve_variants(study, first, first + size)
        taken = time.perf_counter() - start
        warm = size > 1 or study.variants == 1  # the first one reads, and perhaps compiles
        if warm and (taken >= ENOUGH or size == study.variants):
            lost = zip(rows["variant"], rows["status"], rows["reason"], strict=True)
            reasons = (f"variant {number}, {status}: {reason}" for number, status, reason in lost if reason)
            return StudyEstimate(study, size, dict(Counter(rows["status"])), taken / size, next(reasons, ""))
        size = min(size * GROWTH, study.variants)
        place = (place + GOLDEN) % 1


def time_text(seconds: float) -> str:
    """A time in the unit that suits it: `3.2 s`, `14 min`, `2.5 days`."""
    unit, size = next((each for each in reversed(UNITS_OF_TIME) if seconds >= 2 * each[1]), UNITS_OF_TIME[0])
    two_digits = float(f"{seconds / size:.2g}")
    return f"{two_digits:g} {unit}"
