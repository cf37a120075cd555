# SPDX-License-Identifier: MIT
"""What files may hold."""
