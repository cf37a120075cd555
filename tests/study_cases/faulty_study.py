"""A study in which chosen variants kill the process that solves them, or stumble."""

import os
import signal
from dataclasses import dataclass, fields

from mrts.studies.study import Study


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FaultyStudy(Study):
    """The same points, but not for the processes that work for this one: variants kill them, or raise."""

    driver: int
    deadly: tuple[int, ...] = ()
    stumbling: tuple[int, ...] = ()

    def points(self, first, last):
        if os.getpid() != self.driver:
            if any(first <= variant < last for variant in self.deadly):
                os.kill(os.getpid(), signal.SIGKILL)
            if last - first > 1 and any(first <= variant < last for variant in self.stumbling):
                raise ZeroDivisionError("1 / 0")
        return super().points(first, last)

    def descriptions(self, point):
        stumbling = [Study.points(self, variant, variant + 1)[0].tolist() for variant in self.stumbling]
        if os.getpid() != self.driver and point.tolist() in stumbling:
            raise ZeroDivisionError("1 / 0")
        return super().descriptions(point)


def faulty(study, **faults):
    """The same study with faults."""
    same = {field.name: getattr(study, field.name) for field in fields(Study)}
    return FaultyStudy(**same, driver=os.getpid(), **faults)
