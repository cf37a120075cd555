# SPDX-License-Identifier: MIT
"""Our C (kernel/c) and everything that knows its memory: compiling it, loading it, calling it."""
