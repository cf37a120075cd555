# SPDX-License-Identifier: MIT
"""A plan played at a speed that changes while it runs, within every limit."""
