# SPDX-License-Identifier: MIT
"""The commands of `mrts`, one file each: what it takes, and what it does; `options.py` has what they share.

May import base to viewer. Start at `scale.py`.
"""
