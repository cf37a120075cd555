# SPDX-License-Identifier: MIT
"""Our C (`c/`) and everything that knows its memory: compiling it, opening it, calling it.

May import base. Start at `cell_library.py`.
"""
