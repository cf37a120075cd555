# SPDX-License-Identifier: MIT
"""The viewer in the browser; needs the extra 'view' (viser).

May import base to output. Start at `viewer.py`.
"""
