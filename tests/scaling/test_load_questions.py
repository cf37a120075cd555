"""Questions about an uncertain load: what the command line says, what is refused."""

import json

import pytest
from conftest import DATA
from shipped_cells import changed_cell

import mrts
from mrts.cli import main


def test_the_command_line_asks_what_the_cell_file_says(tmp_path, capsys):
    inertia = [[0.02, 0.004, 0], [0.004, 0.2, 0], [0, 0, 0.2]]
    uncertain = {"variation": {"mass": [0.2, 6.0], "izz": [0.5, 2.0]}, "inertia": inertia}
    path = changed_cell(tmp_path, lambda cell: cell["object"].update(uncertain))
    command = ["scale", str(path), str(DATA / "lift.yaml")]
    assert main([*command, "--carry", "mass=6", "--json", str(tmp_path / "out.json")]) == 0
    said = capsys.readouterr().out
    assert "for every load of the box (mass 0.1 … 3 kg" in said
    result = json.loads((tmp_path / "out.json").read_text())
    assert result["load"]["question"] == "guaranteed"
    assert result["binding"]["upper"]["load"]["parameters"] == {"mass": 6.0}
    assert [point["c2"]["upper"] for point in result["load"]["points"]] == pytest.approx([3.352, 1.516], abs=1e-3)
    assert result["selected"]["load"]["mass"] == 3.0
    assert main([*command, "--carry", "mass=3kg", "--json", str(tmp_path / "kg.json"), "-q"]) == 0
    assert json.loads((tmp_path / "kg.json").read_text()) == result
    for wrong in ("mass=3.1kg", "mass=7", "izz=0.8kg", "mass=kg", "mass=6,mass=2"):
        assert main([*command, "--carry", wrong]) == 2
    box = mrts.load_cell(tmp_path / "cell.yaml").load_box
    with pytest.raises(mrts.InputError) as refused:
        box.load_at({"mass": 7.0})
    assert (refused.value.key, refused.value.value) == ("mass", 7.0)
    assert main([*command, "--load", "possible", "--carry", "mass=6"]) == 2
    assert main([*command, "--load", "possible"]) == 0


VARIATION_MISTAKES = {
    "reversed": ({"mass": [2.0, 0.5]}, "lower value exceeds"),
    "negative": ({"izz": [-1.0, 2.0]}, "must be >= 0"),
    "zero mass": ({"mass": [0.0, 2.0]}, "must be > 0"),
    "nan": ({"mass": [float("nan"), 2.0]}, "finite"),
    "unknown": ({"masss": [0.5, 2.0]}, "unknown key 'masss'; did you mean 'mass'?"),
    "one value": ({"mass": [0.5]}, "has 1 values"),
    "a word": ({"mass": "heavy"}, "must be a list"),
    "without the nominal": ({"mass": [2.0, 3.0]}, "must contain 1"),
    "moment without zero": ({"mx": [0.1, 0.3]}, "must contain 0"),
    "nothing": ({}, "at least one range"),
    "offsets": ({"mass": [0.5, 2.0], "com_x": [-0.1, 0.1]}, "'hull: outer'"),
    "offsets and moments": ({"com_x": [-0.1, 0.1], "mx": [-1, 1], "hull": "outer"}, "exclude each other"),
    "hull alone": ({"mass": [0.5, 2.0], "hull": "outer"}, "is for ranges of com_x"),
}


@pytest.mark.parametrize("mistake", VARIATION_MISTAKES)
def test_a_bad_variation_is_refused(mistake, tmp_path, capsys):
    variation, words = VARIATION_MISTAKES[mistake]
    path = changed_cell(tmp_path, lambda cell: cell["object"].update(variation=variation))
    assert main(["scale", str(path), str(DATA / "lift.yaml")]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "cell.yaml: object.variation" in said
