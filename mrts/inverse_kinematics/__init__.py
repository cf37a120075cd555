# SPDX-License-Identifier: MIT
"""Joints from poses: Newton steps along a path (in the kernel), closed forms, joint limits, why an arm cannot follow.

May import base to motion. Start at `variant_tracking.py`.
"""
