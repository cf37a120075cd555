"""What a notebook shows of everything public that a user holds: the answer first, escaped, without a script."""

import dataclasses
import inspect
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA
from shown_results import AWKWARD, with_all_rates, with_awkward_names

import mrts
from mrts.base.notebook.in_notebooks import InNotebooks
from mrts.identification.identified_motors import ArmMotors, MotorIdentification, MotorParameter
from mrts.layout.layout_numbers import LayoutNumbers
from mrts.layout.placement import Placement, PlayedLayout
from mrts.studies.study_folder import StudyFolder


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


def motors(robot):
    """An arm as if a recording had told of its motors."""
    count, blocks = len(robot.joints), np.linspace(0, 1, 4)
    numbers, known = np.full(count, 0.25), np.full(count, fill_value=True)
    each = MotorParameter(numbers, numbers, numbers, known, ("",) * count, ~known, numbers)
    columns = [np.full((4, count), value) for value in (1.0, 2.0, 3.0, 4.0)]
    return ArmMotors(
        robot=robot, armature=each, coulomb=each, viscous=each, offset=numbers, residual_rms=numbers,
        explained=numbers, cutoff=30.0, time=blocks, used=np.full((4, count), fill_value=True), velocity=columns[0],
        acceleration=columns[1], left_over=columns[2], fitted=columns[3],
    )  # fmt: skip


@pytest.fixture(scope="module")
def held(planar_cell, lift, lifted, tmp_path_factory):
    """One object of every public class, by its name: what is found in a few results, and what is made here."""
    folder = tmp_path_factory.mktemp("notebook")
    study = mrts.read_study(DATA.parent / "dual_ur5" / "place.yaml")
    played = PlayedLayout(study.cell, None, None, lifted, 0.25)
    smooth = mrts.retime(with_all_rates(planar_cell), lift, rates=11.0, between=None)
    answered = lifted.what_if()
    roots = [
        dataclasses.replace(lifted, changes=answered),
        smooth,
        mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift),
        mrts.scale(planar_cell.with_mass(24.0), lift),
        mrts.rank_configurations(planar_cell, lift),
        mrts.load_cell(DATA.parent / "squeeze" / "cell.yaml"),
        study,
        StudyFolder(folder, {"digest": "d", "variants": 9, "chunk": 4, "columns": {"variant": {}}}),
        Placement(
            study=study, numbers=LayoutNumbers.of(study, mrts.load_cell(DATA.parent / "dual_ur5" / "cell.yaml")),
            before=None, after=played, reason="", looked_at=9, playable=5, searches=2, stopped="",
        ),
        MotorIdentification("cell", Path("recorded.csv"), tuple(map(motors, planar_cell.robots)), ()),
        mrts.check(DATA / "cell.yaml", DATA / "lift.yaml"),
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


def test_the_answer_of_a_timing_stands_first(held):
    found = held["RetimingResult"]
    tree = shown(found)
    assert "".join(tree.find("p").itertext()) == f"{found.cell.name}: {found.sentence()}"
    durations, limits = tree.findall("table")
    assert f"{found.duration:.4g} s" in "".join(durations.itertext())
    assert found.limits[0][0] in "".join(limits.itertext())


def test_names_from_a_file_stay_text(planar_cell, lift):
    spiteful = with_awkward_names(planar_cell)
    result = mrts.scale(spiteful, lift)
    for value in (spiteful, spiteful.robots[0], result):
        assert AWKWARD in "".join(shown(value).itertext())


def test_figures_show_themselves_without_pyplot(lifted):
    """As IPython asks for it: matplotlib's own Figure shows its name only."""
    from mrts.plots import range_plot  # noqa: PLC0415 (needs an extra)

    plot = range_plot(lifted)
    assert plot._repr_png_().startswith(b"\x89PNG")
    drawn = plot._repr_mimebundle_()["application/vnd.plotly.v1+json"]
    assert drawn["data"]
    assert drawn["layout"]["yaxis"]
