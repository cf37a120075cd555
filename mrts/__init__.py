# SPDX-License-Identifier: MIT
"""Time scaling of cooperative multi-robot motions: how fast may several arms carry one object?

Names are listed in `__init__.pyi` and imported on first use, so that `import mrts` costs next to nothing. What these
functions return is of classes that stand in the packages.
"""

from mrts.base.lazy_names import lazy_names
from mrts.base.version import __version__ as __version__

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
