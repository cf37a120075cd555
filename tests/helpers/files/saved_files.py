"""Saved results, read and written by numpy alone."""

import json

import numpy as np


def contents(path):
    """Description and arrays of a file, by numpy alone."""
    with np.load(path) as file:
        arrays = dict(file)
    return json.loads(bytes(arrays.pop("description"))), arrays


def write(path, description, arrays):
    text = np.frombuffer(json.dumps(description).encode(), dtype=np.uint8)
    np.savez(path, description=text, **arrays)
