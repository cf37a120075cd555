"""Wrong arguments in Python: every public function refuses what it cannot use by an exception of mrts that names it."""

import inspect
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import DATA, UR5
from motor_recordings import exact_recording, random_motors, write_recording

import mrts
from mrts.plots import range_plot, write_plot, write_plots
from mrts.program.solvers import DEFAULT_SOLVER

ZOO = [
    None, True, -1, 10**400, float("nan"), float("-inf"), 1j, "", "nul\0l", "\udcff", b"bytes", Path("nowhere") / "at",
    (), [[1.0], [1.0, 2.0]], ["x"], {"x": 1}, {1}, object(), np.array(3.0), np.array([np.nan]), np.zeros((0, 3)),
]  # fmt: skip
"""Values of all kinds, most of them wrong wherever they are given."""

METHODS = {
    "Cell": ("from_description", "with_load", "with_variation", "with_postures", "with_values", "to_yaml"),
    "LoadBox": ("load_at", "draw", "corners"),
    "ScalingResult": ("write_json",),
    "Study": ("points", "descriptions", "write_variant"),
}
"""Methods that take what a user gives."""

FUNCTIONS = [name for name in mrts.__all__ if inspect.isfunction(getattr(mrts, name))]
WRITERS = {"write_plot": write_plot, "write_plots": write_plots}
"""Public functions that are not of `mrts` itself: their packages are extras."""

BUILT = ("ClosureBound", "CoordinatedMotion", "LoadBox", "ObjectMotion")
"""Classes that a user builds; the others come out of functions."""

STUDY = f"""
cell: {DATA / "cell.yaml"}
motion: {DATA / "lift.yaml"}
vary: {{"robots.left.base.xyz[0]": {{from: -0.1, to: 0.1}}}}
sample: sobol
count: 2
"""


@pytest.fixture(scope="module")
def good(planar_cell):
    """Arguments of everything public with which it works."""
    poses = {"start": {"xyz": [1.25, 0.95, 0]}, "end": {"xyz": [1.25, 1.0, 0]}}
    motion = mrts.load_motion(poses | {"duration": 1.0, "samples": 11, "profile": "cubic"})
    result = mrts.scale(planar_cell, motion)
    whole = result.motion
    box = planar_cell.with_variation(mass=(0.5, 2.0)).load_box
    mrts.save_result(result, "good.npz")
    mrts.write_trajectory_csv(result, "good.csv")
    search = {"cell": planar_cell, "motion": motion, "sharing": None, "between": None}
    search |= {"progress": lambda _done, _total: None}
    recorded = exact_recording(planar_cell, random_motors(6), seconds=8.0, rate=200.0)
    write_recording("recorded.csv", *recorded)
    with_solver = {"solver": DEFAULT_SOLVER}
    objects = {name: getattr(motion, name) for name in ("time", "position", "rotation", "twist", "acceleration")}
    joints = {"object": motion, "q": whole.q, "dq": whole.dq, "ddq": whole.ddq}
    Path("study.yaml").write_text(STUDY, encoding="utf-8")
    study = mrts.read_study("study.yaml")
    mrts.sweep(study, "swept", workers=1)
    plan = {"limits": None, "weights": None, "load": "auto", "distribute": "reserve", "reserve": None, "closure": None}
    smooth = {"start_speed": 0.0, "end_speed": 0.0, "rates": 11.5, "least_energy_in": None}
    smooth |= {"distribute": "least-torque"}
    return {
        "identify": {"cell": planar_cell, "recording": "recorded.csv", "cutoff": 10.0},
        "hold_here": {"cell": planar_cell, "xyz": [1.25, 0.95, 0.0], "rpy": [0.0, 0.0, 0.1]},
        "load_recording": {"path": "recorded.csv"},
        "clearance": {"cell": planar_cell, "motion": motion},
        "check": {"cell": DATA / "cell.yaml", "motion": DATA / "lift.yaml", "progress": lambda _done, _total: None},
        "follow_object": {"cell": planar_cell, "motion": motion},
        "load_cell": {"path": DATA / "cell.yaml"},
        "load_motion": {"motion": DATA / "lift.yaml", "smooth": None},
        "check_plan": {"cell": planar_cell, "plan": "good.csv", "closure": None},
        "simulate": {"plan": result, "controller": None, "errors": None, "trials": 0, "seed": 0}
        | {"override": None, "rates": None, "progress": lambda _done, _total: None},
        "least_reserve": {"solve": lambda reserve: mrts.scale(planar_cell, motion, reserve=reserve)}
        | {"controller": None, "errors": None, "progress": lambda _done, _total: None},
        "load_result": {"path": "good.npz", "cell": planar_cell},
        "rank_configurations": search | with_solver,
        "place": {"study": study, "starts": 1, "looked_at": 2, "between": None}
        | {"progress": lambda _done, _total: None},
        "read_study": {"path": UR5 / "study.yaml"},
        "read_study_folder": {"path": "swept"},
        "retime": search | plan | smooth,
        "save_result": {"result": result, "path": "saved.npz"},
        "scale": search | with_solver | plan | {"select": None, "formulation": "wrench", "rates": False},
        "sweep": {"study": study, "folder": "swept", "workers": 1, "scheduler": None}
        | {"progress": lambda _done, _total: None},
        "torques_for_load": {"result": result, "load": planar_cell.load},
        "write_report": {"result": result, "path": "report.html", "stops": None},
        "write_plot": {"plot": range_plot(result), "path": "figure.png"},
        "write_plots": {"plots": [range_plot(result)], "folder": "figures", "form": "png"},
        "write_ros_bag": {"result": result, "folder": "bag", "merged": False},
        "write_trajectory_csv": {"result": result, "path": "trajectory.csv"},
        "ClosureBound": {"position": 1e-3, "rotation": None},
        "CoordinatedMotion": joints | {"remarks": ()},
        "LoadBox": {"mass": 1.0, "inertia": np.eye(3), "ranges": {"mass": (0.5, 2.0)}},
        "ObjectMotion": objects,
        "Cell.with_load": {"self": planar_cell, "load": planar_cell.load},
        "Cell.with_variation": {"self": planar_cell, "mass": (0.5, 2.0)},
        "Cell.with_postures": {"self": planar_cell, "postures": {"left": [0.0, 0.0, 0.0]}},
        "Cell.from_description": {"description": yaml.safe_load((DATA / "cell.yaml").read_text()), "folder": DATA},
        "Cell.with_values": {"self": planar_cell, "values": {"robots.left.base.xyz": [0.1, 0.0, 0.0]}},
        "Cell.to_yaml": {"self": planar_cell, "path": "cell.yaml"},
        "LoadBox.load_at": {"self": box, "parameters": {"mass": 1.5}},
        "LoadBox.draw": {"self": box, "rng": np.random.default_rng(1), "count": 2},
        "LoadBox.corners": {"self": box, "varying": None},
        "Study.points": {"self": study, "first": 0, "last": 1},
        "Study.descriptions": {"self": study, "point": study.points(0, 1)[0]},
        "Study.write_variant": {"self": study, "index": 1, "folder": "variant"},
        "ScalingResult.write_json": {"self": result, "path": "result.json"},
    }


@pytest.fixture(autouse=True, scope="module")
def folder(tmp_path_factory):
    """Files are written here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("wrong"))
        yield


def test_every_public_function_is_thrown_at(good):
    assert {*FUNCTIONS} <= {*good}
    for name in FUNCTIONS:
        assert {*good[name]} == {*inspect.signature(getattr(mrts, name)).parameters}, name
    for name, methods in METHODS.items():
        assert {f"{name}.{method}" for method in methods} <= {*good}


@pytest.mark.parametrize(
    "name",
    [*FUNCTIONS, *WRITERS, *BUILT, *(f"{name}.{method}" for name, methods in METHODS.items() for method in methods)],
)
def test_wrong_values_are_refused_by_name(name, good):
    home, _, method = name.partition(".")
    called = WRITERS.get(name) or (getattr(getattr(mrts, home), method) if method else getattr(mrts, home))
    arguments = good[name]
    called(**arguments)
    motion = good["scale"]["motion"]
    refused = 0
    for argument in arguments:
        for value in (*ZOO, mrts, motion, good["scale"]["cell"]):
            if argument == "self":
                continue
            message = ""
            try:
                called(**(arguments | {argument: value}))
            except mrts.MrtsError as error:
                message = str(error)
                refused += 1
            except Exception as error:
                raise AssertionError(f"{name}: {argument} = {value!r} raises {error!r}") from error
            assert "\n\n" not in message
    assert refused > len(ZOO) / 2, name
