"""A study on disk: what a folder may hold, what is said of a wrong one, and what becomes of damage."""

import shutil
import subprocess
import sys

import pyarrow.parquet as pq
import pytest
from own_limits import tenth
from study_files import planar_study

import mrts
from mrts.studies.study_folder import opened_study_folder
from mrts.studies.variants import solve_variants

VARY = "vary: {object.mass: [1, 2, 3, 4, 24], 'robots.left.base.xyz[0]': [0, 0.1]}"
CHUNK = 4


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return planar_study(tmp_path_factory.mktemp("study"), VARY)


@pytest.fixture(scope="module")
def columns(study):
    return [solve_variants(study, first, min(first + CHUNK, 10)) for first in (0, 4, 8)]


@pytest.fixture
def complete(study, columns, tmp_path):
    with opened_study_folder(tmp_path / "out", study, lambda: CHUNK) as folder:
        for number, piece in enumerate(columns):
            folder.write(number, [piece])
    return folder


def opened(path, study):
    """Open a folder to go on with it; a new one would have chunks of 7."""
    with opened_study_folder(path, study, lambda: 7) as folder:
        return folder


def test_rows_come_back_in_order_with_their_types_and_units(complete, study):
    found = mrts.read_study_folder(complete.path)
    assert (found.variants, found.chunk, found.chunks, found.digest) == (10, CHUNK, 3, study.digest)
    table = found.table()
    assert table["variant"].to_pylist() == list(range(10))
    assert table.schema.field("object.mass").metadata == {b"unit": b"kg"}
    assert table.schema.field("duration").metadata == {b"unit": b"s"}
    assert {str(field.type) for field in table.schema} == {"int64", "double", "string"}
    heavy = table.to_pylist()[8]
    said = [heavy[name] for name in ("object.mass", "status", "c2_upper", "upper_limit")]
    assert said == [24, "infeasible", None, None]
    assert "these limits conflict" in heavy["reason"]
    assert table["reason"].to_pylist()[:8] == [None] * 8
    assert found.table(["status"]).column_names == ["status"]
    vary = found.record["study"]["vary"]
    assert [each["path"] for each in vary] == ["object.mass", "robots.left.base.xyz[0]"]
    assert (vary[0]["kind"], vary[0]["numbers"]) == ("values", [1, 2, 3, 4, 24])


@pytest.mark.parametrize("damage", ["cut", "empty", "other rows", "other study"])
def test_a_damaged_part_is_dropped_and_said(damage, complete, study, caplog):
    path = complete.part(1)
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-50])
    elif damage == "empty":
        path.write_bytes(b"")
    elif damage == "other rows":
        shutil.copy(complete.part(2), path)
    else:
        table = pq.read_table(path)
        pq.write_table(table.replace_schema_metadata({"study": "another"}), path)
    folder = opened(complete.path, study)
    assert list(folder.parts()) == [0, 2]
    assert "part-00000001.parquet is damaged, or of another study: solved again" in caplog.text
    assert folder.chunk == CHUNK


def test_a_changed_study_is_refused_with_what_differs(complete, study, tmp_path):
    for changed, said in ((VARY.replace("24", "24.000001"), "vary"), (f"{VARY}\nreserve: 0.1", "question")):
        with pytest.raises(mrts.InputError, match=rf"out: holds another study, which differs in {said}"):
            opened(complete.path, planar_study(tmp_path, changed))
    with pytest.raises(mrts.InputError, match="out: holds another study, which differs in limits"):
        opened(complete.path, study.with_limits(tenth))
    assert len(complete.parts()) == 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "is damaged"),
        ("[]", "is not a study of format 3"),
        ('{"format": 2}', "is not a study of format 3"),
        ('{"format": 3, "digest": 3}', "is damaged"),
        (None, r"holds no study: study.json: there is no such file"),
    ],
)
def test_what_is_no_study_is_said(text, said, tmp_path):
    if text is not None:
        (tmp_path / "study.json").write_text(text)
    with pytest.raises(mrts.InputError, match=said):
        mrts.read_study_folder(tmp_path)


def test_two_sweeps_in_one_folder_are_refused_and_the_lock_of_a_dead_one_is_not(complete, study):
    lock = "import fcntl, sys; f = open(sys.argv[1], 'a'); fcntl.flock(f, fcntl.LOCK_EX); print('held', flush=True)"
    command = [sys.executable, "-c", f"{lock}; input()", str(complete.path / ".lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "held\n"
        with pytest.raises(mrts.InputError, match="another sweep writes into it: let it end first"):
            opened(complete.path, study)
        other.kill()
    assert opened(complete.path, study).chunk == CHUNK
