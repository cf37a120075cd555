"""What a notebook shows of everything public that a user holds: the answer first, escaped, without a script."""

import dataclasses
import inspect
import xml.etree.ElementTree as ET

import pytest
from conftest import DATA
from shown_results import AWKWARD, with_awkward_names

import mrts
from mrts.base.notebook import InNotebooks


def shown_by_notebooks(kind):
    """Classes that are made of a class and have tables."""
    for sub in kind.__subclasses__():
        if sub.notebook_tables is not InNotebooks.notebook_tables and not inspect.isabstract(sub):
            yield sub.__name__, sub
        yield from shown_by_notebooks(sub)


for name in mrts.__all__:
    getattr(mrts, name)  # imports every class
CLASSES = dict(shown_by_notebooks(InNotebooks))

LONGEST_PAGE = 40_000
"""Characters: what a notebook shows of one object stays a screen or two."""


@pytest.fixture(scope="module")
def held(planar_cell, lift, lifted, smooth):
    """One object of every public class, by its name: what is found in a few results, and what is made here."""
    roots = [
        mrts.scale(planar_cell.with_mass(24.0), lift),
        dataclasses.replace(lifted, changes=lifted.what_if()),
        smooth,
        mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift),
        mrts.load_cell(DATA.parent / "squeeze" / "cell.yaml"),
        mrts.simulate(lifted),
    ]  # fmt: skip
    found, seen = {}, {}
    while roots:
        value = roots.pop()
        if id(value) in seen:
            continue
        seen[id(value)] = value
        if type(value) in CLASSES.values():
            found.setdefault(type(value).__name__, value)
        if dataclasses.is_dataclass(value):
            roots += [getattr(value, field.name, None) for field in dataclasses.fields(value)]
        elif isinstance(value, dict):
            roots += value.values()
        elif isinstance(value, tuple | list):
            roots += value
    return found


def shown(value):
    """The HTML as a tree; that it is one shows that nothing in it is unescaped."""
    text = value._repr_html_()
    assert "<script" not in text
    assert len(text) < LONGEST_PAGE
    assert " at 0x" not in text
    assert "array(" not in text
    return ET.fromstring(text)  # noqa: S314 (our own text; notebooks' protocol)


def test_what_has_tables_shows_them(held):
    assert set(CLASSES) - set(held) == set()
    for name in CLASSES:
        tree = shown(held[name])
        assert "".join(tree.find("p").itertext()).strip(), name
        cells = ["".join(cell.itertext()) for cell in tree.iter("td")]
        assert any(text.strip() for text in cells), name


def test_names_from_a_file_stay_text(planar_cell, lift):
    spiteful = with_awkward_names(planar_cell)
    result = mrts.scale(spiteful, lift)
    for value in (spiteful, result):
        assert AWKWARD in "".join(shown(value).itertext())
