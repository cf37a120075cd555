# SPDX-License-Identifier: MIT
"""Between the samples: where limits would be overstepped there, and which samples that takes.

May import base to samples. Start at `search.py`.
"""
