# SPDX-License-Identifier: MIT
"""The scene that viewer, report and films draw: arms, object, path, wrenches, camera, colours. Start at `scene.py`.

May import base to studies.
"""
