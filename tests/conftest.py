import os
import shutil
import tempfile
from importlib.resources import files
from pathlib import Path

import pytest
from motion_tables import exact_motions
from random_motors import with_all_rates

import mrts
from mrts.kernel.cache_folder import cache_folder

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(str(files("mrts") / "data")) / "planar_dual_arm"
UR5 = DATA.parent / "dual_ur5"

CACHE = ROOT / "build" / "test-cache"
MOST_ENTRIES = 2000
"""Of cells and libraries in the cache, about 20 kB to 2 MB each; a run adds about 200 where generation has changed."""


def pytest_configure(config):
    """Let tests neither read nor fill the user's cache: theirs, keyed by content, serves all workers and later runs."""
    if hasattr(config, "workerinput"):
        return  # a worker has it from the process that started it
    if sum(1 for _ in CACHE.glob("*/*")) > MOST_ENTRIES:
        shutil.rmtree(CACHE)
    CACHE.parent.mkdir(exist_ok=True)
    os.environ.setdefault("MUJOCO_GL", "egl")  # simulations import it first
    os.environ["MRTS_CACHE_DIR"] = str(CACHE)
    if cache_folder() != CACHE:  # others can write this checkout
        os.environ["MRTS_CACHE_DIR"] = folder = tempfile.mkdtemp(prefix="mrts-tests-")
        config.add_cleanup(lambda: shutil.rmtree(folder))


@pytest.fixture(scope="session")
def private_cache():
    return Path(os.environ["MRTS_CACHE_DIR"])


@pytest.fixture(scope="session")
def planar_cell():
    return mrts.load_cell(DATA / "cell.yaml")


@pytest.fixture(scope="session")
def lift():
    return mrts.load_motion(DATA / "lift.yaml")


@pytest.fixture(scope="session")
def lifted(planar_cell, lift):
    return mrts.scale(planar_cell, lift)


@pytest.fixture(scope="session")
def dual_ur5():
    return mrts.load_cell(UR5 / "cell.yaml")


@pytest.fixture(scope="session")
def lift_and_turn():
    return mrts.load_motion(UR5 / "lift_and_turn.yaml")


@pytest.fixture(scope="session")
def turned(dual_ur5, lift_and_turn):
    return mrts.scale(dual_ur5, lift_and_turn)


@pytest.fixture(scope="session")
def smooth(planar_cell, lift):
    """Within rates of torques, wrenches and joints."""
    return mrts.retime(with_all_rates(planar_cell), lift, rates=11.0)


@pytest.fixture(scope="session")
def exact(dual_ur5):
    """Joints that carry the object exactly, and their c²⁺, by end and number of rows."""
    return exact_motions(dual_ur5)
