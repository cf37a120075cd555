# SPDX-License-Identifier: MIT
"""What a user of the viewer chooses, and what follows from it; knows no browser.

May import base to output, and the viewer's states. Start at `workbench.py`.
"""
