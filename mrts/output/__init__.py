# SPDX-License-Identifier: MIT
"""A result as files and text.

May import base to starting. Start at `saved_result.py`.
"""
