# SPDX-License-Identifier: MIT
"""The viewer in the browser; needs the extra 'view' (viser)."""
