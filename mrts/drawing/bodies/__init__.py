# SPDX-License-Identifier: MIT
"""Bodies and where one looks from: arms, the object, the whole cell. Start at `cell_shapes.py`."""
