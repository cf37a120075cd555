# SPDX-License-Identifier: MIT
"""What stands between a motor and its joint: rotor inertia, friction, how torque falls with speed.

May import base. Start at `joint_motors.py`.
"""
