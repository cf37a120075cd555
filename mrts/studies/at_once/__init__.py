# SPDX-License-Identifier: MIT
"""What many variants solved at once are made of: numbers, limits, answers. Start at variant_numbers.py."""
