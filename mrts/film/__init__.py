# SPDX-License-Identifier: MIT
"""Pictures and films of played motions, without a display; needs the extra 'film' (MuJoCo, matplotlib, ffmpeg).

May import base to report. Start at `film.py`.
"""
