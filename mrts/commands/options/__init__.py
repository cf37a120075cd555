# SPDX-License-Identifier: MIT
"""Options that several verbs share.

May import base to console. Start at `common.py`.
"""
