# SPDX-License-Identifier: MIT
"""How near arms, object and surroundings come to each other along a motion. Needs the extra 'collision' (coal).

May import base to following. Start at `clearance.py`.
"""
