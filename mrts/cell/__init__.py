# SPDX-License-Identifier: MIT
"""What a cell is, how it is generated (the only door to mrts_codegen), and its bound functions.

May import base to kernel. Start at `cell.py`.
"""
