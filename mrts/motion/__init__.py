# SPDX-License-Identifier: MIT
"""What is given: motion of the object and of joints along time, read from files.

May import base. Start at `object_motion.py`.
"""
