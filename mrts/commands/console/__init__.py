# SPDX-License-Identifier: MIT
"""How a command speaks: terminal, progress, files written, exit codes.

May import base to viewer. Start at `terminal.py`.
"""
