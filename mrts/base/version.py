# SPDX-License-Identifier: MIT
"""The version of mrts; pyproject.toml takes it from here."""

__version__ = "0.1.0"
