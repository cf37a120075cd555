# SPDX-License-Identifier: MIT
"""From URDF files to the chains of rigid bodies that carry the object."""
