# SPDX-License-Identifier: MIT
"""Between the samples: where limits would be overstepped there, samples are added.

May import base to samples. Start at `search.py`.
"""
