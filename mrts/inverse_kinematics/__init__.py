# SPDX-License-Identifier: MIT
"""Joints from poses: Newton steps along a path, closed forms, redundant arms, joint limits."""
