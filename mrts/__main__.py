# SPDX-License-Identifier: MIT
"""`python -m mrts`."""

import sys

from mrts.cli import main

sys.exit(main())
