"""An exported library of doubles in this process: its calls with the samples of a motion."""

import ctypes
import re

import numpy as np
from exported_library import run, sources, tool

NO_INTERVAL = {2, 3, 4, 5}
"""Of its statuses: infeasible, empty, undecided, bad argument."""

PLACES = {"inside": 0, "start": 1, "end": 2}

BYTES = 1 << 18
"""More than a workspace has."""


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
        self.motors = bool(self.sizes["MOTORS"])
        joints, limits = self.sizes["JOINTS"], self.sizes["ROWS"]
        moving = {"q": joints, "dq": joints, "ddq": joints, "rotation": 9, "twist": 6, "acceleration": 6}
        self.Sample = structure([*reals(moving), *([("place", ctypes.c_int)] if self.motors else [])])
        self.Range, self.Horizon = range_structures(self.sizes["UNKNOWNS"])
        given = {"load": 10, "lower": limits, "upper": limits, "velocity": joints + 2 + self.sizes["ENDS"]}
        given["weight"] = joints
        if self.motors:
            given |= dict.fromkeys(("armature", "coulomb", "viscous"), joints)
            given |= {"rest": 2, "most": None, "slope": self.sizes["LINES"]}
        if self.sizes["MOTIONS"]:
            points, things = self.sizes["POINTS"], self.sizes["THINGS"]
            given |= {"acceleration_lower": joints, "acceleration_upper": joints, "object_acceleration": 2}
            given |= {"point_speed": points, "point_acceleration": points} if points else {}
            given |= {"friction": things, "tilt": 2 * things} if things else {}
        self.settings = structure(reals(given))()
        self.workspace = ctypes.create_string_buffer(BYTES)
        self.call("default_settings", self.settings)
        getattr(self.code, f"{self.name}_row_text").restype = ctypes.c_char_p

    def call(self, name, *given):
        """What a function of the library returns; structures go by reference."""
        parts = (ctypes.byref(part) if isinstance(part, ctypes.Structure) else part for part in given)
        return getattr(self.code, f"{self.name}_{name}")(*parts)

    def sample(self, motion, index):
        """A sample of a coordinated motion as the library takes it."""
        given = motion.object
        fields = (motion.q, motion.dq, motion.ddq, given.rotation, given.twist, given.acceleration)
        place = "start" if index == 0 else "end" if index == motion.samples - 1 else "inside"
        found = self.Sample(place=PLACES[place]) if self.motors else self.Sample()
        for (name, _), field in zip(self.Sample._fields_, fields, strict=False):
            getattr(found, name)[:] = np.ravel(field[index]).tolist()
        return found

    def range(self, sample, call="range_of_sample"):
        """Status, and the interval of c² as an array, Shape (1, 2) or (0, 2), with the rows that bind at its ends."""
        found = self.Range()
        self.call(call, sample, self.settings, found, self.workspace)
        return found.status, *self._interval(found)

    def horizon(self, motion, call="range_of_sample"):
        """Status, upper end, its sample, row and corner of the load, over a motion."""
        horizon, sampled = self.Horizon(), None
        corners = (ctypes.c_double * 10 * self.sizes["CORNERS"]).in_dll(self.code, f"{self.name}_load_corners")
        self.call("horizon_start", horizon)
        for index in range(motion.samples):
            one, low, high = self.Range(), ctypes.c_int(-1), ctypes.c_int(-1)
            sample = self.sample(motion, index)
            if call == "guaranteed_range":
                ends = [ctypes.byref(end) for end in (low, high)]
                self.call(call, sample, self.settings, corners, len(corners), one, *ends, self.workspace)
            else:
                self.call(call, sample, self.settings, one, self.workspace)
            self.call("horizon_add", horizon, one)
            if horizon.upper_sample == index:
                sampled = self._rows(one)[1][0], high.value
        return horizon.status, horizon.upper, horizon.upper_sample, *sampled

    def _interval(self, found):
        if found.status in NO_INTERVAL:
            return np.zeros((0, 2)), []
        return np.array([[found.lower, found.upper]]), [self._rows(found)]

    def _rows(self, part):
        lower, upper = part.lower_rows[: part.lower_count], part.upper_rows[: part.upper_count]
        return [[self.call("row_text", row).decode() for row in rows] for rows in (lower, upper)]

    def torques(self, sample, c2):
        """Status, torques and wrenches at a c²."""
        torque, wrench = ((ctypes.c_double * self.sizes[name])() for name in ("JOINTS", "WRENCHES"))
        status = self.call("torques", sample, self.settings, ctypes.c_double(c2), torque, wrench, self.workspace)
        return status, np.array(torque), np.array(wrench)


def range_structures(unknowns):
    """The structures of a range and of a horizon."""
    count, rows, ends = ctypes.c_int, ctypes.c_int * (unknowns + 1), reals({"lower": None, "upper": None})
    named = [("lower_count", count), ("upper_count", count), ("lower_rows", rows), ("upper_rows", rows)]
    sampled = [(name, ctypes.c_long) for name in ("samples", "lower_sample", "upper_sample")]
    return structure([("status", count), *ends, *named]), structure([("status", count), *ends, *sampled])


def reals(sizes):
    """Fields of so many numbers each; None is one that is no array."""
    return [(name, ctypes.c_double if size is None else ctypes.c_double * size) for name, size in sizes.items()]


def structure(fields):
    """A class of ctypes with these fields."""
    return type("Structure", (ctypes.Structure,), {"_fields_": fields})
