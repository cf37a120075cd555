"""The tests themselves: quick ones in every folder, files that fit one sitting, and what they share stands apart."""

import re

import pytest
from cell_bank import PLANAR, SPATIAL
from conftest import ROOT

pytestmark = pytest.mark.quick

TESTS = ROOT / "tests"
FILES = sorted(TESTS.glob("*/test_*.py"))
MOST_LINES = 400
MOST_STRUCTURES = 20


@pytest.mark.parametrize("folder", sorted({path.parent.name for path in FILES}))
def test_every_folder_has_a_quick_test(folder):
    assert any("pytest.mark.quick" in path.read_text(encoding="utf-8") for path in (TESTS / folder).glob("test_*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_fits_one_sitting_and_takes_nothing_from_another(path):
    text = path.read_text(encoding="utf-8")
    assert text.count("\n") <= MOST_LINES
    assert not re.findall(r"^(?:from|import) test_\w+", text, re.MULTILINE)


def test_random_cells_have_few_structures():
    """Each takes up to 15 s to generate and compile, while limits, objects and motions cost next to nothing."""
    assert len(PLANAR) + len(SPATIAL) <= MOST_STRUCTURES
