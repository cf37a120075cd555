# SPDX-License-Identifier: MIT
"""How a verb of the command line speaks: terminal, progress, files written, exit codes.

May import base to viewer. Start at `terminal.py`.
"""
