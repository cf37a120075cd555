"""A limit of one's own that workers can import."""

from dataclasses import replace

from mrts.limits.cell_limits import torque_limits
from mrts.limits.rows import LimitRows


def tenth(cell, motion):
    """A tenth of each torque limit."""
    whole = torque_limits(cell, motion).limits
    names = tuple(replace(name, kind="own") for name in whole.names)
    return LimitRows(limits=replace(whole, names=names, lower=whole.lower / 10, upper=whole.upper / 10))
