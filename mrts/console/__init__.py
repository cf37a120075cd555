# SPDX-License-Identifier: MIT
"""How a verb of the command line speaks: terminal, progress, files written, exit codes."""
