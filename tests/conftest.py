import os
from importlib.resources import files
from pathlib import Path

import pytest

import mrts

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(str(files("mrts") / "data")) / "planar_dual_arm"


@pytest.fixture(scope="session", autouse=True)
def private_cache(tmp_path_factory):
    """Tests neither read nor fill the user's cache."""
    folder = tmp_path_factory.mktemp("cache")
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
