# SPDX-License-Identifier: MIT
"""Colours and round numbers, which plots and scenes share.

May import base to layout. Start at `colours.py`.
"""
