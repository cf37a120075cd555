# SPDX-License-Identifier: MIT
"""Motion of the whole cell: every arm's joints along the object's motion, and whether given joints hold it."""
