# SPDX-License-Identifier: MIT
"""What a controller does with a plan: plays it at a speed that changes, within every limit, or on a cell that differs.

May import base to timing. Start at `speed_override.py`; `simulate.py` needs the extra 'simulate' (MuJoCo).
"""
