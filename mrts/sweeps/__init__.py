# SPDX-License-Identifier: MIT
"""All variants of a study, solved by many processes into a folder.

May import base to studies. Start at `sweep.py`.
"""
