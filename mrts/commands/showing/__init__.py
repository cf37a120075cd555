# SPDX-License-Identifier: MIT
"""What `mrts view` opens and films. Start at `shown.py`."""
