# SPDX-License-Identifier: MIT
"""A result as files and text: saved results, tables, bags, test vectors of an export."""
