# SPDX-License-Identifier: MIT
"""What build time and run time share: errors, text, files, frames, the manifest, the box of loads.

Imports no other room. Start at `manifest.py`.
"""
