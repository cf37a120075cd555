"""The tests themselves: quick ones in every folder."""

import pytest
from conftest import ROOT

pytestmark = pytest.mark.quick


def test_every_folder_has_a_quick_test():
    files = sorted((ROOT / "tests").glob("*/test_*.py"))
    quick = {path.parent for path in files if "pytest.mark.quick" in path.read_text(encoding="utf-8")}
    assert quick == {path.parent for path in files}
