"""`mrts check`, and verbs that refuse a motion before anything is compiled."""

import json
import shutil
import subprocess
import sys

import pytest
from conftest import UR5
from damaged_cells import sound, written

from mrts.cell.remarks import NO_COLLISIONS
from mrts.cli import main


@pytest.fixture
def far(tmp_path):
    """Files of a cell with an arm that is too far away."""
    cell, motion = sound()
    cell["robots"][1]["base"]["xyz"] = [1.7, 0, 0]
    return [str(path) for path in written(tmp_path, cell, motion)]


def test_exit_codes_and_json(far, tmp_path, capsys):
    assert main(["check", str(UR5 / "cell.yaml")]) == 0
    assert "next: mrts scale" in capsys.readouterr().out
    assert main(["check", *far, "-q", "--json", "-"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == "impossible"
    assert told["clearance"] is None
    assert [arm["follows"] for arm in told["arms"]] == [True, False]
    assert NO_COLLISIONS in [one["text"] for one in told["assumed"]]
    assert told["arms"][1]["shift"][0] < 0
    output = tmp_path / "out.json"
    assert main(["check", *far[::-1], "--json", str(output)]) == 2
    assert json.loads(output.read_text(encoding="utf-8"))["status"] == "wrong-input"
    out, err = capsys.readouterr()
    assert "two files swapped" in out
    assert str(output) in err
    assert main(["check", *far[::-1], "-q"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main(["check", str(tmp_path / "nowhere.yaml"), far[1]]) == 2
    assert "1 mistake in the files" in capsys.readouterr().out


def test_an_unreachable_cell_is_refused_before_its_dynamics_are_generated(far, tmp_path):
    """Only what follows the object is compiled, and what takes long to import is not imported."""
    script = "import sys; from mrts.cli import main; code = main(sys.argv[1:]); print(*sys.modules); sys.exit(code)"
    cache = tmp_path / "cache"
    done = subprocess.run(
        [sys.executable, "-c", script, "scale", *far],
        capture_output=True,
        text=True,
        check=False,
        env={"MRTS_CACHE_DIR": str(cache), "PATH": str(shutil.which("gcc")).rpartition("/")[0]},
    )
    assert done.returncode == 2
    assert "robot 'right' cannot reach its grasp" in done.stderr
    assert f"mrts check {far[0]} {far[1]}" in done.stderr
    assert {path.stem for path in cache.rglob("*") if path.is_file()} <= {"motion"}
    assert not {"yourdfpy", "trimesh", "scipy"} & {*done.stdout.split()}
