"""A limit of one's own that workers can import."""

from dataclasses import replace

from mrts.limits.cell_limits import torque_limits


def tenth(cell, motion):
    """A tenth of each torque limit."""
    rows = torque_limits(cell, motion)
    names = tuple(replace(name, kind="own") for name in rows.names)
    return replace(rows, names=names, lower=rows.lower / 10, upper=rows.upper / 10)
