"""How many random cases a test draws."""

import os

import pytest

MORE = int(os.environ.get("MORE_DRAWS", "1"))
"""Times as many; `make fuzz` asks for them."""


def draws(count):
    """So many, or that many times more."""
    return count * MORE


def seeds(few, more=0):
    """Seeds of random cases: `few` in `make test`, `more` in `make test-slow`, both times as many in `make fuzz`."""
    return [*range(few), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(few, draws(few + more)))]
