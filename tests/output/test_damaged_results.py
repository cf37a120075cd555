"""Saved results that are damaged, foreign or made by hand: refused by name, never run."""

import io
import json
import zipfile

import numpy as np
import pytest

import mrts
from mrts.output.saved_result import VERSION, seal


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


VERSIONS = (
    (lambda d: d.update(version=VERSION + 1), "version = .*: this mrts reads version .*; .* Update mrts"),
    (lambda d: d.update(version=1), "version = 1: .* Save the result again"),
    (lambda d: d.update(manifest_format=1), "version = .*: this mrts reads version"),
    (lambda d: d.update(format="other"), "is no saved result of mrts"),
)

EDITS = (
    lambda d, _: d["result"].update(c2=1.0),
    lambda _, arrays: arrays["trajectory.torque"].__setitem__((3, 2), 7.0),
    lambda _, arrays: arrays.update({"motion.q": arrays["motion.q"].reshape(-1, 3)}),
    lambda _, arrays: arrays.pop("trajectory.wrench"),
    lambda _, arrays: arrays.update({"motion.dq": arrays["motion.ddq"], "motion.ddq": arrays["motion.dq"]}),
)

FORGERIES = (
    lambda d: d["result"]["found"]["upper"].pop("c2"),
    lambda d: d["result"].update(c2="fast"),
    lambda d: d["result"]["found"].update(status="colourful"),
    lambda d: d["result"].update(cell=d["result"]["motion"]),
    lambda d: d["result"]["motion"].update({"class": "Popen"}),
    lambda d: d["result"].update(extra=1),
    lambda d: d["result"].update(motion={"same": "nowhere"}),
    lambda d: d["result"]["motion"].update(q={"array": "nowhere"}),
    lambda d: d["result"]["trajectory"]["holding"]["torque"].update(kind="O"),
    lambda d: d["result"]["cell"]["manifest"]["cell"].update(name="../../x"),
    lambda d: d["result"]["cell"].update(reserve=2.0),
    lambda d: d["result"]["cell"]["manifest"].update(source="../x.c"),
    lambda d: d.update(result=[]),
)


@pytest.fixture
def changed(lifted, tmp_path):
    """Writes a saved result with changes to its description, or to its arrays too."""
    path = tmp_path / "result.npz"

    def write_changed(change, *, sealed=True):
        mrts.save_result(lifted, path)
        description, arrays = contents(path)
        change(description) if sealed else change(description, arrays)
        write(path, description, arrays, sealed=sealed)
        return path

    return write_changed


def test_a_file_of_another_version_is_refused(changed):
    for change, words in VERSIONS:
        with pytest.raises(mrts.InputError, match=f"result.npz.*{words}"):
            mrts.load_result(changed(change))


@pytest.mark.parametrize("edit", EDITS)
def test_an_edited_file_is_refused(edit, changed):
    path = changed(edit, sealed=False)
    with pytest.raises(mrts.InputError, check=lambda error: (error.where, error.key) == (str(path), "seal")):
        mrts.load_result(path)


def test_what_mrts_did_not_write_is_refused(changed):
    for number, forgery in enumerate(FORGERIES):
        path = changed(forgery)
        with pytest.raises(mrts.InputError, match=r"result\.npz.*damaged"):
            print(number, mrts.load_result(path))


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
    for name in ("trajectory.torque", "description"):
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
    for _ in range(150):
        damaged = bytearray(whole[: rng.integers(len(whole))] if rng.random() < 0.3 else whole)
        for place in rng.integers(len(damaged) or 1, size=3):
            damaged[place : place + 1] = rng.bytes(1)
        path.write_bytes(damaged)
        try:
            assert mrts.load_result(path).json_text() == lifted.json_text()  # what was hit does not matter
        except mrts.InputError as error:
            assert str(path) in str(error)  # noqa: PT017 (either outcome is right)
            refused += 1
    assert refused > 100
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
    with pytest.raises(mrts.InputError, match="there is no such saved result"):
        mrts.load_result(tmp_path / "nothing.npz")
