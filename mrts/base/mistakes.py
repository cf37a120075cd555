# SPDX-License-Identifier: MIT
"""All that is wrong at once: what independent checks refuse is noted, and raised as one error."""

from collections.abc import Iterator
from contextlib import contextmanager

from mrts.base.errors import InputError


class Mistakes:
    """Notes what is refused, in order.

    Attributes:
        found: So far, each mistake once.
    """

    def __init__(self) -> None:
        self.found: list[InputError] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Note an error of what is done inside, with what it carries, and go on after it."""
        try:
            yield
        except InputError as error:
            self.add(error)

    def add(self, error: InputError) -> None:
        """Note an error with what it carries."""
        said = {str(known) for known in self.found}
        self.found += [each for each in error.each() if str(each) not in said]

    def raise_noted(self) -> None:
        """Go on if there is none.

        Raises:
            InputError: The first, which carries the others.
        """
        if self.found:
            first, *others = self.found
            raise first.with_others(others)
