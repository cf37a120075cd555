# SPDX-License-Identifier: MIT
"""What a notebook shows of the objects that a user holds: a sentence and small tables, without a script.

May import base. Start at `in_notebooks.py`.
"""
