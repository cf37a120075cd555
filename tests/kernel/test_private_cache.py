"""The cache is compiled and run: it is used only where nobody else can write it, and made so that nobody else can."""

import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import DATA

from mrts.cell.generation import generated_in_cache
from mrts.kernel.cache_folder import only_ours
from mrts.kernel.compiler import compiled_library

pytestmark = pytest.mark.quick

SAYS = "import sys, mrts; from mrts.kernel.cache_folder import cache_folder; print(cache_folder(*sys.argv[1:]))"
ANSWER = '__attribute__((visibility("default"))) int answer(void) { return 42; }\n'

SPOILS = {
    "others may write it": lambda folder: folder.chmod(0o777),
    "others may write it, but not rename": lambda folder: folder.chmod(0o1777),
    "a group may write it": lambda folder: folder.chmod(0o770),
}
if os.getuid() == 0:
    SPOILS |= {"it belongs to another": lambda folder: os.chown(folder, 65534, -1)}


def where(*inside, **environment):
    """Cache folder of a process of its own, and what it says on the way."""
    removed = [name for name, value in environment.items() if value is None]
    variables = {name: value for name, value in (os.environ | environment).items() if name not in removed}
    done = subprocess.run(
        [sys.executable, "-c", SAYS, *inside], capture_output=True, text=True, check=True, env=variables
    )
    return Path(done.stdout.strip()), done.stderr


def test_all_in_the_cache_is_the_users_only(tmp_path, monkeypatch):
    """Whatever the umask."""
    monkeypatch.setenv("MRTS_CACHE_DIR", str(tmp_path / "new" / "cache"))
    shutil.copytree(DATA, tmp_path / "cell")
    before = os.umask(0)
    try:
        generated_in_cache(tmp_path / "cell" / "cell.yaml")
        compiled_library("answer", ANSWER)
    finally:
        os.umask(before)
    found = [tmp_path / "new" / "cache", *(tmp_path / "new" / "cache").rglob("*")]
    assert {path.suffix for path in found} == {"", ".c", ".json", ".so"}
    assert not [path for path in found if stat.S_IMODE(path.stat().st_mode) & 0o077]


@pytest.mark.parametrize("spoil", SPOILS)
def test_a_cache_that_others_can_write_is_not_used(spoil, tmp_path):
    folder = tmp_path / "cache"
    folder.mkdir()
    assert where(MRTS_CACHE_DIR=str(folder)) == (folder, "")
    SPOILS[spoil](folder)
    used, said = where(MRTS_CACHE_DIR=str(folder))
    assert used.name.startswith("mrts-")
    assert not used.exists()  # it went with the process
    assert "the cache is not used, because" in said
    assert str(folder) in said
    assert "MRTS_CACHE_DIR" in said
    assert not list(folder.iterdir())


def test_a_folder_in_the_cache_that_others_can_write_is_not_used(tmp_path):
    planted = tmp_path / "lib" / "0123"
    planted.mkdir(parents=True)
    planted.chmod(0o777)
    assert where("lib", "4567", MRTS_CACHE_DIR=str(tmp_path)) == (tmp_path / "lib" / "4567", "")
    used, said = where("lib", "0123", MRTS_CACHE_DIR=str(tmp_path))
    assert tmp_path not in used.parents
    assert str(planted) in said
    (tmp_path / "lib" / "89").symlink_to(planted)
    assert str(tmp_path / "lib" / "89") in where("lib", "89", MRTS_CACHE_DIR=str(tmp_path))[1]


@pytest.mark.parametrize("file", ["answer.so", "answer.so by link"])
def test_a_library_that_others_could_have_written_is_compiled_again(file, tmp_path, monkeypatch):
    monkeypatch.setenv("MRTS_CACHE_DIR", str(tmp_path))
    compiled_library("answer", ANSWER)
    (library,) = tmp_path.rglob("answer.so")
    before = library.read_bytes()
    planted = before + b"planted"
    library.unlink()  # this process has it open
    if "link" in file:
        (tmp_path / "elsewhere.so").write_bytes(planted)
        library.symlink_to(tmp_path / "elsewhere.so")
    else:
        library.write_bytes(planted)
        library.chmod(0o666)
    assert not only_ours(library)
    compiled_library("answer", ANSWER)
    assert only_ours(library)
    assert library.read_bytes() == before
