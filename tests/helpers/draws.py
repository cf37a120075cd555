"""How many random cases a test draws."""

import os

MORE = int(os.environ.get("MORE_DRAWS", "1"))
"""Times as many; `make fuzz` asks for them."""


def draws(count):
    """So many, or that many times more."""
    return count * MORE
