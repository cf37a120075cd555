"""Exit codes mean what they say: streams that are closed, signals, full disks, defects."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from command_line import mrts_process
from conftest import DATA

from mrts.cli import main

FILES = (DATA / "cell.yaml", DATA / "lift.yaml")
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}


def shell(line, folder):
    """A line of the shell, where `mrts` is the command and $FILES the shipped example."""
    environment = ENVIRONMENT | {"FILES": " ".join(map(str, FILES)), "PYTHON": sys.executable}
    line = f'mrts() {{ "$PYTHON" -m mrts "$@"; }}; {line}'
    return subprocess.run(
        ["/bin/sh", "-c", line], capture_output=True, text=True, check=False, cwd=folder, env=environment
    )


def stumble(error):
    def load_motion(path):
        if error is RecursionError:
            load_motion(path)
        raise error

    return load_motion


@pytest.mark.quick
@pytest.mark.parametrize(
    ("error", "said"),
    [
        (KeyError("x"), "internal error at scale.py:"),
        (SystemExit(1), "SystemExit: 1. This is a defect of mrts"),
        (RecursionError, "RecursionError: maximum recursion depth exceeded"),
        (MemoryError(), "out of memory"),
    ],
)
def test_a_defect_is_one_paragraph_with_an_exit_code_of_its_own(error, said, monkeypatch, capsys):
    monkeypatch.setattr("mrts.motion.motion_file.load_motion", stumble(error))
    assert main(["scale", *map(str, FILES)]) == 70
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.startswith("mrts: ")
    assert (err.count("\n"), len(err) < 1000) == (1, True)
    for words in (("--debug", "scale", *FILES), ("scale", *FILES, "--debug")):
        assert main([*map(str, words)]) == 70
        traced = capsys.readouterr().err
        assert traced.startswith("Traceback (most recent call last)")
        assert traced.endswith(err)


@pytest.mark.parametrize(
    ("line", "code", "said"),
    [
        ("mrts scale $FILES --json out.json >&-", 2, "mrts: error: standard output: cannot be written: Bad file"),
        ("mrts scale $FILES --json out.json -q >&-", 0, ""),
        ("mrts scale $FILES --json out.json 2>&-", 0, ""),
        ("mrts scale $FILES --json out.json <&- >&- 2>&-", 2, ""),
        ("mrts scale none.yaml none.yaml 2>&-", 2, ""),
        ("mrts --help >/dev/full", 2, "mrts: error: standard output: cannot be written: No space left on device"),
        ("(mrts scale $FILES --json -; echo $? >code) | true; exit $(cat code)", 141, ""),
    ],
)
def test_streams_that_are_closed_or_full(line, code, said, tmp_path, planar_cell):
    assert planar_cell.name  # generated already
    done = shell(line, tmp_path)
    assert done.returncode == code, done.stderr
    assert done.stderr.startswith(said)
    assert said or done.stderr == ""
    if "out.json" in line:
        assert json.loads((tmp_path / "out.json").read_text())["status"] == "feasible"


def is_running(number):
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_signals_end_the_work_tidily(number, tmp_path):
    """While the compiler hangs: it ends as well, and no file stays half written."""
    compiler = tmp_path / "cc"
    compiler.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/started\nsleep 1000\n")
    compiler.chmod(0o755)
    environment = os.environ | {"CC": str(compiler), "MRTS_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-m", "mrts", "scale", *map(str, FILES), "--json", str(tmp_path / "out.json")]
    heard = partial(signal.signal, number, signal.SIG_DFL)  # tests that were started by nohup ignore it
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment, preexec_fn=heard) as process:  # noqa: PLW1509
        started = tmp_path / "started"
        while not (started.exists() and started.read_text().strip()):
            time.sleep(0.02)
            assert process.poll() is None
        process.send_signal(number)
        said = process.communicate(timeout=30)[1]
    assert process.returncode == 128 + number
    assert said in {"mrts: terminated\n", "mrts: the terminal is gone\n"}
    assert not (tmp_path / "out.json").exists()
    assert [path for path in tmp_path.rglob("*") if path.name.startswith(".") or path.suffix == ".so"] == []
    deadline = time.monotonic() + 30
    while is_running(int(started.read_text())):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def small_files(limit):
    """Let writing beyond some bytes fail, as on a full disk."""

    def apply():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    return apply


def test_on_a_full_disk_what_fits_is_written_and_the_answer_is_printed(tmp_path, planar_cell):
    assert planar_cell.name
    old = tmp_path / "plots" / "power_and_energy.png"
    old.parent.mkdir()
    old.write_text("old")
    options = ["--json", "r.json", "--csv", "r.csv", "--save", "r.npz", "--ros-bag", "bag", "--plot", "plots"]
    done = mrts_process("scale", *FILES, *options, "--report", "r.html", cwd=tmp_path, preexec_fn=small_files(90_000))
    assert done.returncode == 2
    assert "c² ∈ [0, 3.062]" in done.stdout
    assert done.stderr.count("mrts: error: ") == done.stderr.count("cannot be written: File too large") == 4
    assert done.stderr.count("\n") == 4
    left = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*"))
    assert left == ["plots", "plots/power_and_energy.png", "r.csv", "r.npz"]
    assert old.read_text() == "old"
