# SPDX-License-Identifier: MIT
"""Plans played by a controller on a cell that is not quite the plan's (the extra 'simulate': MuJoCo).

May import base to timing. Start at `simulate.py`.
"""
