# SPDX-License-Identifier: MIT
"""What a hand can exert on the object: polytopes of the contact wrench. A new kind is one file.

May import base. Start at `contact.py`.
"""
