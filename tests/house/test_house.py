"""What keeps the house in order: light import, borders between packages, notation, documentation."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

import mrts
from mrts.cell.record import read_generated

pytestmark = pytest.mark.quick

SOURCES = sorted([*(ROOT / "mrts").rglob("*.py"), *(ROOT / "codegen").rglob("*.py")])
HEAVY = ("casadi", "scipy", "pydantic", "yaml", "yourdfpy", "trimesh", "lxml", "matplotlib", "mrts_codegen", "plotly")
HEAVY += ("rich", "rosbags", "viser")
LAST_EQUATION = 49
NUMBERS = re.compile(r"\((\d+)\)")


def imported(path: Path):
    """Names of all modules that a file imports, with the function each import stands in (None at the top)."""
    found = []

    def visit(node, function):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                found.extend((alias.name, function) for alias in child.names)
            elif isinstance(child, ast.ImportFrom):
                found.append((child.module or "", function))
            visit(child, child.name if isinstance(child, ast.FunctionDef) else function)

    visit(ast.parse(path.read_text(encoding="utf-8")), None)
    return found


def test_import_is_light():
    script = f"import sys, mrts; print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("profile", ["constant", "optimal"])
def test_scaling_a_cached_cell_imports_what_it_uses(dual_ur5, profile):
    """Neither scipy nor what reads cell files and URDFs, and of the verbs and their work only its own."""
    data = ROOT / "mrts" / "data" / "dual_ur5"
    idle = ["difflib", "mrts.cell.cell_file"]
    if profile == "constant":
        idle += ["mrts.timing", "numpy.ma", "numpy.random"]
    idle += [name for name in HEAVY if name not in {"yaml", "mrts_codegen"}]
    script = (
        "import sys; from mrts.cli import main; code = main(sys.argv[1:])\n"
        f"print(code, [name for name in {idle!r} if name in sys.modules])\n"
        "print(sorted(name for name in sys.modules if name.startswith('mrts.commands.') and 'console' not in name))"
    )
    line = ["scale", data / "cell.yaml", data / "lift_and_turn.yaml", "--profile", profile, "--quiet"]
    done = subprocess.run([sys.executable, "-c", script, *line], capture_output=True, text=True, check=True)
    verb = ["mrts.commands." + name for name in ("options", "scale", "signals")]
    assert done.stdout == f"0 []\n{verb}\n"
    assert dual_ur5.library


def test_only_one_seam_joins_run_time_to_build_time():
    users = {
        path.name: {function for name, function in imported(path) if name.startswith("mrts_codegen")}
        for path in (ROOT / "mrts").rglob("*.py")
    }
    users = {name: functions for name, functions in users.items() if functions}
    assert set(users) == {"generation.py"}
    assert not [name for name, functions in users.items() if None in functions]  # only inside functions: on demand


def test_every_public_name_resolves_and_is_documented():
    for name in mrts.__all__:
        assert getattr(mrts, name).__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = mrts.nonsense


def tables(text):
    """Rows of the tables of a Markdown page, each a list of cells."""
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]


def notation():
    """Rows of the page's tables, without their heads: symbols, equations, words."""
    parts = re.split(r"^## .*", (ROOT / "docs" / "notation.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    return [tables(part)[2:] for part in parts]


def test_every_name_of_the_notation_stands_in_its_file():
    for row in notation()[0]:
        names, places = re.findall(r"`(\w+)`", row[4]), row[5].split(", ")
        assert names, row
        texts = [(ROOT / place).read_text(encoding="utf-8") for place in places]
        for name in names:
            assert any(re.search(rf"\b{name}\b", text) for text in texts), (name, places)
        assert all(any(re.search(rf"\b{name}\b", text) for name in names) for text in texts), row


def test_the_notation_is_complete():
    rows = notation()[0]
    letters = {letter for row in rows for letter in row[0].split(", ")}
    wanted = {"τ_i", "q_i", "q_i'", "q_i''", "D_i", "G_i", "J_i", "F_i = [f_i; ν_i]", "B_i", "S_i", "E_i", "A_i", "r_i"}
    wanted |= {"L", "P", "S", "Q", "J_D", "W", "Φ", "c²", "x", "α_i", "𝓔", "I_w", "g", "m", "I", "A_1", "b_1", "A_2"}
    assert wanted <= letters
    names = {name for row in rows for name in re.findall(r"`(\w+)`", row[4])}
    for cell in (path.parent for path in (ROOT / "generated").glob("*/manifest.json")):
        manifest, _ = read_generated(cell)
        for function in manifest.functions.values():
            assert {*function.inputs, *function.outputs} <= names


def equation_homes():
    homes = []
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                first = (ast.get_docstring(node) or "").split(":")[0]
                if re.fullmatch(r"Eqs?\. \(\d+\)(, \(\d+\))*", first):
                    place = str(path.relative_to(ROOT))
                    homes += [(int(number), node.name, place) for number in NUMBERS.findall(first)]
    return homes


def test_every_equation_has_exactly_one_home():
    homes = equation_homes()
    assert sorted(number for number, _, _ in homes) == list(range(1, LAST_EQUATION + 1))
    listed = [(int(number), row[1].strip("`"), row[2]) for row in notation()[1] for number in NUMBERS.findall(row[0])]
    assert sorted(listed) == sorted(homes)


def test_links_of_the_documentation_lead_somewhere():
    for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md")):
        for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), (page, link)


def test_the_python_example_of_the_readme_runs(tmp_path, capsys, monkeypatch):
    code = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL).group(1)
    monkeypatch.chdir(ROOT)
    for name in ("result.json", "result.npz"):
        code = code.replace(name, str(tmp_path / name))
    exec(compile(code, "README.md", "exec"), {})  # noqa: S102
    assert "3.062" in capsys.readouterr().out
