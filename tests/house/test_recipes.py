"""The recipes of docs/extending.md: each is followed as it stands, in a copy of the repository."""

import re

import pytest
from conftest import ROOT
from recipe import Recipe

PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^## (\d\. [^\n]+)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))
MOST_FILES = 3


@pytest.mark.slow
def test_each_recipe_does_what_it_promises_in_three_files_and_all_of_them_keep_the_house_rules(tmp_path):
    whole = Recipe("", tmp_path).copy(ROOT)
    for title, text in RECIPES.items():
        followed = Recipe(text, tmp_path).follow()
        assert followed.ran > 0, title
        assert 1 <= len(followed.touched) <= MOST_FILES, (title, sorted(followed.touched))
        followed.undo()
    for text in RECIPES.values():
        whole.touched |= Recipe(text, tmp_path).follow(run=False).touched
    whole.check()
