# SPDX-License-Identifier: MIT
"""A cell as a self-contained C99 library: model, kernel, API, tests, build files."""
