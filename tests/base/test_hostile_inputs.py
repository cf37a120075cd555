"""Small inputs that mean large work, and inputs that are no files: refused at once, in bounded time and memory."""

import json
import os
import socket
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from conftest import ROOT

import mrts

PATIENCE = 8.0
"""Processor time for a file [s]: what takes one on an idle machine, and a bomb would take minutes or for ever."""

SCRIPT = ROOT / "tests" / "helpers" / "files" / "hostile_inputs.py"
KINDS = ("cell", "motion", "result", "urdf", "generated")


def cost(*arguments, timeout=180):
    """Outcome and processor time of each file, read in a process with limits."""
    done = subprocess.run(
        [sys.executable, SCRIPT, *arguments], capture_output=True, text=True, timeout=timeout, check=False
    )
    assert done.returncode == 0, done.stderr
    found = {name: (outcome, seconds) for name, outcome, seconds in map(json.loads, done.stdout.splitlines())}
    assert list(found) == list(arguments)
    for name, (outcome, seconds) in found.items():
        assert seconds < PATIENCE, (name, seconds)
        assert outcome.isprintable(), name
    return {name: outcome for name, (outcome, _) in found.items()}


def check_outcomes(folder, suffix, kinds, texts):
    """Write files of these texts, read them as these kinds, and expect what stands beside them."""
    for name, (text, _) in texts.items():
        (folder / f"{name}.{suffix}").write_text(text, encoding="utf-8")
    found = cost(*(f"{kind}:{folder / name}.{suffix}" for name in texts for kind in kinds))
    for argument, outcome in found.items():
        assert texts[Path(argument).stem][1] in outcome, argument


LAYERS = "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 10))
"""Nine values, nine of those, and so on, nine times."""


@pytest.mark.slow
def test_yaml_costs_what_its_size_says(tmp_path):
    texts = {
        "aliases": (f"a0: &a0 [1, 1, 1]\n{LAYERS}", "more than 20000 values"),
        "key": ("? [a, b]\n: 1\n", "a key must be text"),
        "itself": ("a: &a [*a]\n", "'*a' stands inside of what it repeats"),
        "deep": ("[" * 100_000, "more than 20 deep"),
    }
    check_outcomes(tmp_path, "yaml", ("cell", "motion"), texts)


def test_what_is_no_regular_file_is_refused_without_waiting(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "socket"))
    (tmp_path / "link").symlink_to(tmp_path / "pipe")
    kinds = {"pipe": "is a pipe", "socket": "is a socket", "link": "is a pipe"}
    places = {tmp_path / name: text for name, text in kinds.items()}
    places |= {Path("/dev/zero"): "is a device", Path("/dev/stdin"): "regular file"}
    places |= {Path("/proc/self/mem"): "", Path("/proc/self/pagemap"): "", Path("/proc/kcore"): ""}
    arguments = [f"{kind}:{place}" for place in places for kind in KINDS]
    for suffix in (".csv", ".mcap", ".db3"):
        os.mkfifo(tmp_path / f"pipe{suffix}")
        arguments.append(f"motion:{tmp_path}/pipe{suffix}")
        places[tmp_path / f"pipe{suffix}"] = "is a pipe"
    found = cost(*arguments)
    for argument, outcome in found.items():
        assert outcome != "read", argument
        assert places[Path(argument.partition(":")[2])] in outcome, argument


def member(shape):
    """The bytes of a .npy file that says it has this shape, and holds nothing."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()


@pytest.fixture(scope="module")
def saved(planar_cell, lift, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "result.npz"
    mrts.save_result(mrts.scale(planar_cell, lift), path)
    return path


def test_archives_unpack_to_what_fits_their_size(saved, tmp_path):
    with zipfile.ZipFile(saved) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    zeros = bytes(100_000_000)
    spoiled = {
        "huge": ({"trajectory.torque.npy": member((12_500_000,)) + zeros}, "would unpack to"),
        "header": ({"trajectory.torque.npy": member((10**15,))}, "is no saved result of mrts, or damaged"),
        "foreign": ({"extra.npy": zeros}, "would unpack to"),
        "many": ({f"{k}.npy": b"" for k in range(5000)}, "is no saved result of mrts, or damaged"),
    }
    for name, (change, _) in spoiled.items():
        with zipfile.ZipFile(tmp_path / f"{name}.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for inside, content in (contents | change).items():
                archive.writestr(inside, content)
    found = cost(*(f"result:{tmp_path / name}.npz" for name in spoiled))
    for argument, outcome in found.items():
        assert spoiled[Path(argument).stem][1] in outcome


INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def urdf(links, parent):
    """An arm with one joint that carries so many links, each fixed to another."""

    def link(name):
        return f'<link name="{name}">{INERTIAL}</link>'

    def joint(name, above, below, kind="fixed"):
        return f'<joint name="{name}" type="{kind}"><parent link="{above}"/><child link="{below}"/></joint>'

    sides = "".join(link(f"s{k}") + joint(f"f{k}", parent(k), f"s{k}") for k in range(links))
    return f'<robot name="r">{link("base")}{link("tip")}{joint("j", "base", "tip", "continuous")}{sides}</robot>'


def test_urdfs_cost_what_their_size_says(tmp_path):
    texts = {
        "side": (urdf(10_000, lambda _: "tip"), "at most 2000"),
        "wide": (urdf(1900, lambda _: "tip"), "read"),
        "chain": (urdf(1900, lambda k: f"s{k - 1}" if k else "tip"), "read"),
        "loop": (urdf(1900, lambda k: f"s{(k + 1) % 1900}"), "the joints form a loop"),
        "depth": ('<robot name="r">' + "<a>" * 700_000, "not well-formed"),
    }
    check_outcomes(tmp_path, "urdf", ["urdf"], texts)
