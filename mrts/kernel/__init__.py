# SPDX-License-Identifier: MIT
"""Our C (kernel/c) and everything that knows its memory: compiling it, opening it, calling it."""
