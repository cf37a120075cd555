"""Saved results that are damaged, foreign or made by hand: refused by name, never run."""

import io
import json
import zipfile

import numpy as np
import pytest
from saved_files import contents, write

import mrts


def spoil_array(name, change):
    def spoil(_description, arrays):
        arrays[name] = change(arrays[name])

    return spoil


def moved(counts):
    """The same number of rows in all, -1 of them at the first end."""
    counts.flat[1] += counts.flat[0] + 1
    counts.flat[0] = -1
    return counts


def spoil_word(change):
    return lambda description, _arrays: change(description)


def with_change(change, **steps):
    """What changes would do, of which one is spoilt."""
    answer = {"status": "feasible", "c2": 1.0, "duration": 1.0, "limits": [], "reason": ""}
    entry = {"kind": "mass", "robot": "", "element": "", "step": 0.1, "after": answer}
    change(entry)
    whole = {"share": 0.1, "shift": 0.01, "turn": 0.01, "before": answer, "changes": [entry], "left_out": ""} | steps
    return spoil_word(lambda description: description.update(what_if=whole))


MISTAKES = {
    "newer": (spoil_word(lambda d: d.update(version=8)), "version = 8: this mrts reads version 7; .* Update mrts"),
    "older": (spoil_word(lambda d: d.update(version=1)), "version = 1: .* Save the result again"),
    "no version": (spoil_word(lambda d: d.pop("version")), "version: this mrts reads"),
    "foreign": (spoil_word(lambda d: d.update(format="other")), "is no saved result of mrts"),
    "missing word": (spoil_word(lambda d: d.pop("fallbacks")), "fallbacks: Field required"),
    "unknown word": (spoil_word(lambda d: d.update(extra=1)), "extra: Extra inputs"),
    "edited manifest": (spoil_word(lambda d: d["manifest"].update(gravity=[0, 0, 0])), "manifest: was edited"),
    "hostile name": (spoil_word(lambda d: d["manifest"].update(name="../../x")), r"manifest\.name: must be letters"),
    "hostile source": (spoil_word(lambda d: d["manifest"].update(source="../x.c")), "manifest: its source must be"),
    "ragged pose": (
        spoil_word(lambda d: d["manifest"]["robots"][0]["T_base_tip"].update(R=[[1], [2, 3], []])),
        r"manifest\.robots\[0\]\.T_base_tip\.R: .* one rectangular shape",
    ),
    "nan word": (spoil_word(lambda d: d.update(c2=float("nan"))), "c2: .* finite number"),
    "negative c2": (spoil_word(lambda d: d.update(c2=-1)), "c2: .* greater than 0"),
    "short load": (spoil_word(lambda d: d["load"].pop()), "load: .* at least 10 items"),
    "fallbacks": (spoil_word(lambda d: d["range_fallbacks"].append(0)), "range_fallbacks, several: must have 1 values"),
    "fewer rows": (spoil_word(lambda d: d["rows"].pop()), "binding_row = .*must be from 0 to"),
    "ragged weights": (spoil_word(lambda d: d["rule"].update(weights=[[1, 2], [3]])), "weights: .* rectangular"),
    "missing array": (lambda _, arrays: arrays.pop("torque"), "torque: this array is missing"),
    "unknown array": (lambda _, arrays: arrays.update(more=np.zeros(2)), "more: this array does not belong here"),
    "wrong shape": (spoil_array("q", lambda q: q[:, :5]), r"q = \(101, 5\): must be numbers with Shape \(101, 6\)"),
    "fewer samples": (spoil_array("time", lambda t: t[:-1]), r"position = .* Shape \(100, 3\)"),
    "flat time": (spoil_array("time", lambda t: t[:, None]), r"time = \(101, 1\): .* Shape \(101,\)"),
    "nan": (spoil_array("torque", lambda t: np.where(t == t[3, 2], np.nan, t)), "torque = nan: must be finite"),
    "huge": (spoil_array("ddq", lambda a: 1e200 + a), r"ddq = 1e\+200: must be finite numbers, at most 1e\+60"),
    "huge end": (spoil_array("c2_upper", lambda u: 1e200 + u), r"c2_upper = 1e\+200: must be finite numbers, at most"),
    "huge word": (spoil_word(lambda d: d["load"].__setitem__(4, 1e200)), r"load\.4 = 1e\+200: must be at most 1e\+60"),
    "huge whole number": (spoil_word(lambda d: d.update(fallbacks=10**400)), "fallbacks = 1.*: must be at most 1e"),
    "infinite": (spoil_array("ddq", lambda a: a * np.inf), "ddq = .*: must be finite"),
    "nan in a range": (spoil_array("c2_upper", lambda u: u * np.nan), "c2_upper = nan"),
    "words": (spoil_array("wrench", lambda w: w.astype(str)), "wrench = .* must be numbers"),
    "broken counts": (spoil_array("binding_count", lambda c: c + 0.5), "must be whole numbers"),
    "unknown status": (spoil_array("status", lambda s: s + 7), "status = .*must be from 0 to 3"),
    "negative count": (spoil_array("binding_count", moved), "binding_count = -1"),
    "counts of nothing": (
        spoil_array("binding_count", lambda c: c * np.nan),
        "binding_count = .*must be whole numbers",
    ),
    "no such change": (with_change(lambda entry: entry.update(kind="colour")), r"what_if\.changes\.0\.kind: Input"),
    "no step": (with_change(lambda entry: entry.pop("step")), r"what_if\.changes\.0\.step: Field required"),
    "wrong steps": (
        with_change(lambda _entry: None, share=7.0),
        r"share: must be a number from .* save the result again",
    ),
    "lost rows": (spoil_array("binding_row", lambda r: r[:-1]), r"binding_row: must have Shape \(\d+,\), the sum"),
    "unknown parameter": (
        spoil_word(lambda d: d.update(loads=[{"parameters": {"x": 1}, "load": [1] * 10}])),
        "pattern",
    ),
    "time back": (spoil_array("time", lambda t: t[::-1]), "time: must have Shape .* strictly increase"),
    "no rotation": (spoil_array("rotation", lambda R: 2 * R), "rotation: must hold rotation matrices"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_wrong_file_is_refused(mistake, lifted, tmp_path):
    spoil, words = MISTAKES[mistake]
    path = tmp_path / "result.npz"
    mrts.save_result(lifted, path)
    description, arrays = contents(path)
    spoil(description, arrays)
    write(path, description, arrays)
    with pytest.raises(mrts.InputError, match=f"result.npz.*{words}"):
        mrts.load_result(path)


def test_places_in_a_study_and_conflicts_are_checked(planar_cell, lift, tmp_path):
    path = tmp_path / "result.npz"
    mrts.save_result(mrts.scale(planar_cell.with_variation(mass=(0.2, 200.0)), lift), path)
    description, arrays = contents(path)
    assert description["conflicts"]
    for key in ("range", "sample", "load", "rows"):
        one = json.loads(json.dumps(description))
        entry = one["conflicts"][0]
        entry[key] = [9999] * len(entry["rows"]) if key == "rows" else 9999
        write(path, one, arrays)
        with pytest.raises(mrts.InputError, match=f"conflicts: {key} = 9999: must be from 0 to"):
            mrts.load_result(path)
    uneven, other = (json.loads(json.dumps(description)) for _ in range(2))
    uneven["conflicts"][0]["moves"].pop()
    other["study"]["question"] = "sometimes"
    for one, words in ((uneven, "of one length"), (other, "should match pattern")):
        write(path, one, arrays)
        with pytest.raises(mrts.InputError, match=words):
            mrts.load_result(path)
    description["study"]["points"][0] = 77
    write(path, description, arrays)
    with pytest.raises(mrts.InputError, match=r"study\.points = 77"):
        mrts.load_result(path)


class Bomb:
    """Unpickling it would make a file."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return (open, (self.path, "w"))


def test_nothing_in_a_file_is_unpickled(lifted, tmp_path):
    path, mark = tmp_path / "result.npz", tmp_path / "executed"
    mrts.save_result(lifted, path)
    description, arrays = contents(path)
    for name in ("torque", "description"):
        spoiled = arrays | {"description": np.frombuffer(json.dumps(description).encode(), dtype=np.uint8)}
        spoiled[name] = np.array([Bomb(mark)], dtype=object)
        np.savez(path, **spoiled)
        with pytest.raises(mrts.InputError, match=r"no saved result of mrts, or damaged .*Object arrays"):
            mrts.load_result(path)
    np.array([Bomb(mark)], dtype=object).dump(path)
    with pytest.raises(mrts.InputError, match="no saved result of mrts, or damaged"):
        mrts.load_result(path)
    assert not mark.exists()


def test_damaged_and_foreign_files_are_refused(lifted, tmp_path):
    path = tmp_path / "result.npz"
    mrts.save_result(lifted, path)
    whole = path.read_bytes()
    rng = np.random.default_rng(5)
    refused = 0
    for _ in range(300):
        damaged = bytearray(whole[: rng.integers(len(whole))] if rng.random() < 0.3 else whole)
        for place in rng.integers(len(damaged) or 1, size=3):
            damaged[place : place + 1] = rng.bytes(1)
        path.write_bytes(damaged)
        try:
            assert mrts.load_result(path).json_text() == lifted.json_text()  # what was hit does not matter
        except mrts.InputError as error:
            assert str(path) in str(error)  # noqa: PT017 (either outcome is right)
            refused += 1
    assert refused > 200
    npy, other = io.BytesIO(), io.BytesIO()
    np.save(npy, np.zeros(3))
    np.savez(other, a=np.zeros(3))
    for foreign in (b"", b"c2: 3", npy.getvalue(), other.getvalue()):
        path.write_bytes(foreign)
        with pytest.raises(mrts.InputError, match=r"result\.npz: is no saved result of mrts"):
            mrts.load_result(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("description.npy", b"0")
        archive.infolist()[0].file_size = 4_100_000_000  # as if it were compressed well
    with pytest.raises(mrts.InputError, match="would unpack to 4100000000"):
        mrts.load_result(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("description.npy", "text")
    with pytest.raises(mrts.InputError, match="is no saved result of mrts, or damaged"):
        mrts.load_result(path)
    with pytest.raises(mrts.InputError, match="there is no such saved result"):
        mrts.load_result(tmp_path / "nothing.npz")
    with pytest.raises(mrts.InputError, match="is a folder"):
        mrts.load_result(tmp_path)
