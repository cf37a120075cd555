# SPDX-License-Identifier: MIT
"""A first cell from URDFs alone: hands found by name, postures and bases proposed, a motion that can be played.

May import base to plots. Start at `proposal.py`.
"""
