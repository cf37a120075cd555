# SPDX-License-Identifier: MIT
"""What is wrong, assumed and out of reach in a cell and a motion.

May import base to following. Start at `check.py`.
"""
