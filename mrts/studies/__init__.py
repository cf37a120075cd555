# SPDX-License-Identifier: MIT
"""Many questions about a cell at once."""
