# SPDX-License-Identifier: MIT
"""The fastest speed along a path in the plane of s̈ and ṡ²: regions of admissible speeds, and passes through them.

May import base to refinement. Start at `fastest_profile.py`.
"""
