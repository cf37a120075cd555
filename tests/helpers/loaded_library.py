"""An exported library of a cell with motors in this process: its calls with the samples of a motion."""

import ctypes
import re

import numpy as np
from exported_library import run, sources, tool

BELOW = 3
"""Intervals below the highest that a range tells: `_BELOW` of the header."""

PLACES = {"inside": 0, "start": 1, "end": 2}


class LoadedLibrary:
    """A library in double precision, compiled and loaded, with the settings of its cell file."""

    def __init__(self, folder, place):
        (header,) = (folder / "include").glob("*.h")
        self.name, text = header.stem, header.read_text()
        self.sizes = {
            name: int(value) for name, value in re.findall(rf"#define {self.name.upper()}_(\w+) (\d+)\s", text)
        }
        shared = place / f"{self.name}.so"
        run(tool("gcc", "gcc"), "-std=c99", "-O2", "-shared", "-fPIC", f"-I{folder}/include", *sources(folder), "-lm",
            "-o", shared)  # fmt: skip
        self.code = ctypes.CDLL(str(shared))
        joints, unknowns = self.sizes["JOINTS"], self.sizes["UNKNOWNS"]
        real, rows = ctypes.c_double, ctypes.c_int * (unknowns + 1)
        parts = {"q": joints, "dq": joints, "ddq": joints, "rotation": 9, "twist": 6, "acceleration": 6}
        self.Sample = structure([(name, real * count) for name, count in parts.items()] + [("place", ctypes.c_int)])
        named = [("lower_count", ctypes.c_int), ("upper_count", ctypes.c_int), ("lower_rows", rows), ("upper_rows", rows)]
        ends = [("lower", real), ("upper", real)]
        came = [("lower_from", ctypes.c_long), ("upper_from", ctypes.c_long)]
        interval = structure([*ends, *came, *named])
        below = [("below_count", ctypes.c_int), ("below", interval * BELOW)]
        self.Range = structure([("status", ctypes.c_int), *ends, *named, *below])
        self.settings, self.workspace = ctypes.create_string_buffer(1 << 14), ctypes.create_string_buffer(1 << 18)
        self._call("default_settings", self.settings)
        self._call("row_text", 0)
        getattr(self.code, f"{self.name}_row_text").restype = ctypes.c_char_p

    def _call(self, name, *given):
        return getattr(self.code, f"{self.name}_{name}")(*given)

    def sample(self, motion, index):
        """A sample of a coordinated motion as the library takes it."""
        given = motion.object
        fields = (motion.q, motion.dq, motion.ddq, given.rotation, given.twist, given.acceleration)
        place = "start" if index == 0 else "end" if index == motion.samples - 1 else "inside"
        found = self.Sample(place=PLACES[place])
        for (name, kind), field in zip(self.Sample._fields_, fields, strict=False):
            setattr(found, name, kind(*np.ravel(field[index])))
        return found

    def range(self, motion, index, call="range_of_sample"):
        """Status, and the intervals of c² as an array, ascending, with the rows that bind at their ends."""
        found = self.Range()
        self._call(call, ctypes.byref(self.sample(motion, index)), self.settings, ctypes.byref(found), self.workspace)
        if found.status in {2, 3, 4, 5}:
            return found.status, np.zeros((0, 2)), []
        every = [found, *found.below[: found.below_count]][::-1]
        ends = [[part.lower, part.upper] for part in every]
        return found.status, np.array(ends), [self.rows(part) for part in every]

    def rows(self, part):
        """Texts of the rows that bind at both ends."""
        lower, upper = part.lower_rows[: part.lower_count], part.upper_rows[: part.upper_count]
        return [[self._call("row_text", row).decode() for row in rows] for rows in (lower, upper)]

    def torques(self, motion, index, c2):
        """Status and torques at a c²."""
        torque, wrench = (ctypes.c_double * self.sizes[name] for name in ("JOINTS", "WRENCHES"))
        torque, wrench = torque(), wrench()
        status = self._call(
            "torques",
            ctypes.byref(self.sample(motion, index)),
            self.settings,
            ctypes.c_double(c2),
            torque,
            wrench,
            self.workspace,
        )
        return status, np.array(torque), np.array(wrench)


def structure(fields):
    """A class of ctypes with these fields."""
    return type("Structure", (ctypes.Structure,), {"_fields_": fields})
