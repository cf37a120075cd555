# SPDX-License-Identifier: MIT
"""Time scaling of cooperative multi-robot motions."""

__version__ = "0.1.0"
