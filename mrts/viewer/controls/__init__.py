# SPDX-License-Identifier: MIT
"""Controls of the viewer's panel that change the choices of a workbench; needs the extra 'view' (viser).

May import base to output, and the viewer's workbench. Start at `edit_controls.py`.
"""
