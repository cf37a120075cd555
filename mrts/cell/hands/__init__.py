# SPDX-License-Identifier: MIT
"""What a hand can exert on the object: polytopes of the contact wrench."""
