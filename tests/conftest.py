import os
from importlib.resources import files
from pathlib import Path

import pytest

import mrts

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(str(files("mrts") / "data")) / "planar_dual_arm"


@pytest.fixture(scope="session", autouse=True)
def private_cache(tmp_path_factory):
    """Tests neither read nor fill the user's cache; workers of one run share theirs."""
    run = tmp_path_factory.getbasetemp()
    folder = (run.parent if "PYTEST_XDIST_WORKER" in os.environ else run) / "cache"
    folder.mkdir(mode=0o700, exist_ok=True)
    os.environ["MRTS_CACHE_DIR"] = str(folder)
    return folder


@pytest.fixture(scope="session")
def planar_cell(private_cache):
    assert private_cache.is_dir()
    return mrts.load_cell(DATA / "cell.yaml")


@pytest.fixture(scope="session")
def lift():
    return mrts.load_motion(DATA / "lift.yaml")


@pytest.fixture(scope="session")
def dual_ur5(private_cache):
    assert private_cache.is_dir()
    return mrts.load_cell(DATA.parent / "dual_ur5" / "cell.yaml")
