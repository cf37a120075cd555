# SPDX-License-Identifier: MIT
"""One factor for the whole motion: the range of c² and its intersection, the choice of c, loads known within a box."""
