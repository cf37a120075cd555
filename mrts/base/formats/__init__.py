# SPDX-License-Identifier: MIT
"""What files may hold: records that are checked by themselves, and larger formats that pydantic checks."""
