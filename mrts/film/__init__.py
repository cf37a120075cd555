# SPDX-License-Identifier: MIT
"""Pictures and films of played motions, drawn without a display; needs the extra 'film' (matplotlib, pillow).

May import base to report. Start at `film.py`.
"""
