"""Geometry as an input: the same functions as with it folded in, and the same C for all cells with the same chains."""

import casadi as ca
import numpy as np
import yaml
from casadi_cells import casadi_cell
from conftest import DATA
from mrts_codegen.cell_model import read_cell_model
from mrts_codegen.generate import generate_chains
from mrts_codegen.generated_functions import build_functions
from published_robots import ROBOTS
from shipped_cells import cell_file, cell_of_arms, shipped

import mrts
from mrts.cell.generation import CACHED_STEM

ROUNDING = 1e-12
"""Of sums in another order, relative to the largest entry."""

TIAGO = str(ROBOTS / "tiago_description/robots/tiago_dual.urdf")


def tiago_cell(folder, rng):
    """Two arms of one TIAGo, its torso and more held anywhere."""
    robots = [
        {
            "name": side,
            "urdf": TIAGO,
            "tip_link": f"arm_{side}_tool_link",
            "posture": rng.uniform(-0.5, 0.5, 7).tolist(),
            "base": {"xyz": rng.uniform(-1, 1, 3).tolist(), "rpy": rng.uniform(-3, 3, 3).tolist()},
            "grasp": {"xyz": rng.uniform(-1, 1, 3).tolist(), "rpy": rng.uniform(-3, 3, 3).tolist()},
            "torque": [50.0] * 7,
            "fixed": {"torso_lift_joint": float(rng.uniform(0, 0.3)), "head_1_joint": float(rng.uniform(-1, 1))},
        }
        for side in ("left", "right")
    ]
    return cell_of_arms(folder, *robots, gravity=rng.uniform(-9, 9, 3).tolist())


def test_functions_of_geometry_are_those_with_it_folded_in(tmp_path):
    rng = np.random.default_rng(17)
    keys, sources = set(), set()
    for _ in range(3):
        model = read_cell_model(tiago_cell(tmp_path, rng))
        chains, c_source, functions = generate_chains(model, CACHED_STEM)
        keys.add(chains.chains)
        sources.add(c_source)
        geometry = casadi_cell(tmp_path / "cell.yaml").geometry
        folded = build_functions(model, "folded", bake=True)
        assert functions.keys() == folded.keys()
        for name, function in functions.items():
            given = [rng.uniform(-1, 1, function.size_in(place)) for place in range(function.n_in() - 1)]
            ours, theirs = function.call([*map(ca.DM, given), ca.DM(geometry)]), folded[name].call(given)
            for found, wanted in zip(map(ca.DM.full, ours), map(ca.DM.full, theirs), strict=True):
                np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUNDING * (1 + np.max(np.abs(wanted))))
    assert len(keys) == len(sources) == 1


def test_another_number_of_a_cell_file_needs_no_generation(tmp_path, monkeypatch):
    monkeypatch.setenv("MRTS_CACHE_DIR", str(tmp_path / "cache"))
    description = shipped()
    first = mrts.load_cell(cell_file(tmp_path, description))
    monkeypatch.setattr("mrts_codegen.generate.generate_chains", None)
    monkeypatch.setattr("mrts.kernel.compiler.compile_library", None)
    description["name"] = "another"
    description["gravity"] = [0.0, -1.6, 0.0]
    description["robots"][0]["base"] = {"xyz": [0.05, 0.1, 0.0], "rpy": [0.0, 0.0, 0.2]}
    description["robots"][1]["grasp"]["xyz"] = [1.15, 0.0, 0.0]
    description["robots"][1]["torque"][0] = 77.0
    description["object"]["mass"] = 1.0
    second = mrts.load_cell(cell_file(tmp_path, description))
    assert second.generated.manifest.source_sha256 == first.generated.manifest.source_sha256
    assert not np.array_equal(second.geometry, first.geometry)


def test_chains_that_differ_do_not_share(tmp_path):
    keys = set()
    for plane, mass in (("xy", 5), (None, 5), ("xy", 5.05)):
        text = (DATA / "planar_arm.urdf").read_text().replace('mass value="5"', f'mass value="{mass}"')
        (tmp_path / "planar_arm.urdf").write_text(text)
        description = yaml.safe_load((DATA / "cell.yaml").read_text()) | {"plane": plane}
        for robot in description["robots"]:
            robot["wrench"] = {}
        keys.add(read_cell_model(cell_file(tmp_path, description)).chains_key(CACHED_STEM))
    assert len(keys) == 3
