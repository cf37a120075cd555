# SPDX-License-Identifier: MIT
"""What a user should know of a cell: likely mistakes, numbers that look like placeholders, and what is assumed."""

__all__: list[str] = []
