# SPDX-License-Identifier: MIT
"""Names of a package that are imported on first use (PEP 562)."""

from collections.abc import Callable
from importlib import import_module
from typing import Any


def lazy_names(package: str, file: str) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """`__all__`, `__getattr__` and `__dir__` of a package.

    The stub beside its `__init__.py` lists the names as type checkers read it, one import a line (Scientific Python's
    SPEC 1).

    Args:
        package: Its `__name__`.
        file: Its `__file__`.
    """
    with open(f"{file}i", encoding="utf-8") as stub:  # noqa: PTH123 (pathlib is slow to import)
        imports = [line.split() for line in stub if line.startswith("from ")]
    homes = {name: module for _, module, _, name, *_ in imports if not name.startswith("_")}

    def attribute(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        return getattr(import_module(homes[name]), name)

    return sorted(homes), attribute, lambda: sorted({*homes, *vars(import_module(package))})
