"""Saved results that are damaged, foreign or made by hand: refused by name, never run."""

import io
import json
import zipfile

import numpy as np
import pytest
from saved_files import contents, write

import mrts
from mrts.output.saved_result import VERSION

VERSIONS = {
    "newer": (lambda d: d.update(version=VERSION + 1), "version = .*: this mrts reads version .*; .* Update mrts"),
    "older": (lambda d: d.update(version=1), "version = 1: .* Save the result again"),
    "no version": (lambda d: d.pop("version"), "version: this mrts reads"),
    "another manifest": (lambda d: d.update(manifest_format=1), "version = .*: this mrts reads version"),
    "foreign": (lambda d: d.update(format="other"), "is no saved result of mrts"),
}


@pytest.mark.parametrize("mistake", VERSIONS)
def test_a_file_of_another_version_is_refused(mistake, lifted, tmp_path):
    change, words = VERSIONS[mistake]
    path = tmp_path / "result.npz"
    mrts.save_result(lifted, path)
    description, arrays = contents(path)
    change(description)
    write(path, description, arrays)
    with pytest.raises(mrts.InputError, match=f"result.npz.*{words}"):
        mrts.load_result(path)


EDITS = {
    "a word": lambda d, _: d["result"].update(c2=1.0),
    "a limit": lambda d, _: d["result"]["cell"]["manifest"]["cell"]["robots"][0].update(torque_upper=[1.0, 1.0, 1.0]),
    "a number": lambda _, arrays: arrays["trajectory.torque"].__setitem__((3, 2), 7.0),
    "a shape": lambda _, arrays: arrays.update({"motion.q": arrays["motion.q"].reshape(-1, 3)}),
    "a kind": lambda _, arrays: arrays.update({"motion.q": arrays["motion.q"].astype(np.float32)}),
    "a lost array": lambda _, arrays: arrays.pop("trajectory.wrench"),
    "another array": lambda _, arrays: arrays.update(more=np.zeros(2)),
    "exchanged arrays": lambda _, arrays: arrays.update(
        {"motion.dq": arrays["motion.ddq"], "motion.ddq": arrays["motion.dq"]}
    ),
}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edited_file_is_refused(edit, lifted, tmp_path):
    path = tmp_path / "result.npz"
    mrts.save_result(lifted, path)
    description, arrays = contents(path)
    EDITS[edit](description, arrays)
    write(path, description, arrays, sealed=False)
    with pytest.raises(mrts.InputError) as error:
        mrts.load_result(path)
    assert (error.value.where, error.value.key) == (str(path), "seal")


FORGERIES = {
    "a lost field": lambda d: d["result"]["found"]["upper"].pop("c2"),
    "a field of another kind": lambda d: d["result"].update(c2="fast"),
    "no status": lambda d: d["result"]["found"].update(status="colourful"),
    "a class of another place": lambda d: d["result"].update(cell=d["result"]["motion"]),
    "a class that no result holds": lambda d: d["result"]["motion"].update({"class": "Popen"}),
    "an unknown field": lambda d: d["result"].update(extra=1),
    "a place that is not": lambda d: d["result"].update(motion={"same": "nowhere"}),
    "an array that is not": lambda d: d["result"]["motion"].update(q={"array": "nowhere"}),
    "an array of texts": lambda d: d["result"]["trajectory"]["holding"]["torque"].update(dtype="U9"),
    "a hostile name": lambda d: d["result"]["cell"]["manifest"]["cell"].update(name="../../x"),
    "a reserve of twice all": lambda d: d["result"]["cell"].update(reserve=2.0),
    "a hostile source": lambda d: d["result"]["cell"]["manifest"].update(source="../x.c"),
    "no result": lambda d: d.pop("result"),
    "a list": lambda d: d.update(result=[]),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_what_mrts_did_not_write_is_refused(forgery, lifted, tmp_path):
    path = tmp_path / "result.npz"
    mrts.save_result(lifted, path)
    description, arrays = contents(path)
    FORGERIES[forgery](description)
    write(path, description, arrays)
    with pytest.raises(mrts.InputError, match=r"result\.npz.*damaged"):
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
