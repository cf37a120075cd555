# SPDX-License-Identifier: MIT
"""The equations of the closed chain: pure functions of symbols."""
