# SPDX-License-Identifier: MIT
"""The verbs of the command line, one file each: what it takes, and what it does.

May import base to console. Start at `scale.py`.
"""
