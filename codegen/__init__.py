# SPDX-License-Identifier: MIT
"""Build time of mrts: URDFs and a cell file in, C source and a manifest out."""
