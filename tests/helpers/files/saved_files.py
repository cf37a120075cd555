"""Saved results, read and written by numpy alone."""

import json

import numpy as np

from mrts.output.saved_result import seal


def contents(path):
    """Description and arrays of a file, without their seal."""
    with np.load(path) as file:
        arrays = dict(file)
    del arrays["seal"]
    return json.loads(bytes(arrays.pop("description"))), arrays


def write(path, description, arrays, *, sealed=True):
    """Write a file; one that mrts did not seal has the seal of another."""
    arrays = arrays | {"description": np.frombuffer(json.dumps(description).encode(), dtype=np.uint8)}
    np.savez(path, seal=seal(arrays if sealed else {}), **arrays)
