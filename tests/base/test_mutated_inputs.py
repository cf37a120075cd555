"""Thousands of damaged input files of every kind: an answer, a named outcome or one clear sentence, and in time.

A failure names its kind and seed; `FUZZ_CASES=1 FUZZ_SEED=SEED pytest tests/base/test_mutated_inputs.py -k KIND`
repeats it.
`make fuzz` runs many more; CI runs what stands here.
"""

import json
import os
import random
import re
import shutil
import time
from collections.abc import Callable

import pytest
from conftest import DATA, ROOT
from mrts_codegen.cell_model import build_cell_model

import mrts
from mrts.cell.cell_file import CellDescription
from mrts.cell.record import read_generated
from mrts.cli import main
from mrts.studies.variants import solve_variants

NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "-0", "0", "1e-320", "9" * 400, "-1", "1e12", "1_0", "0x10", "1:30")
WORDS = (
    "\x1b[31m", "\u202e", "\u200b", "\x00", "\x9b", "\ufeff", "\U000e0001", "{", "{0}", "{known:>9999999999}", "%s",
    "$x$", "../../x", "~", "null", "true", "*a", "&a", "<<", "!!python/name:os.system", "\\", '"', "'", "#", ":", "- ",
    "\t", "<!--", "]]>", "&#0;", "&lt;", "\r\n", "\n\n", "日本", "²", "é" * 300, "x" * 5000,
)  # fmt: skip
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
KEY = re.compile(r"(?m)^[ -]*([A-Za-z_]+):")
ELEMENT = re.compile(r"<(\w+)[^<>]*/>|<(\w+)[^<>]*>.*?</\2>", re.DOTALL)


def mutated(content: bytes, seed: int) -> bytes:
    """A damaged copy of a valid file; the same seed does the same damage."""
    rng, text = random.Random(seed), content.decode("latin-1")  # noqa: S311 (not for secrets)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        text = rng.choice((_flip, _cut, _twice, _number, _number, _word, _line, _swap_keys, _element))(text, rng)
    return text.encode("latin-1")


def _flip(text: str, rng: random.Random) -> str:
    for _ in range(rng.choice((1, 1, 8))):
        place = rng.randrange(len(text) + 1)
        text = text[:place] + chr(rng.randrange(256)) + text[place + 1 :]
    return text


def _cut(text: str, rng: random.Random) -> str:
    start, stop = _piece(text, rng)
    return text[:start] if rng.random() < 0.3 else text[:start] + text[stop:]


def _twice(text: str, rng: random.Random) -> str:
    start, stop = _piece(text, rng)
    return text[:stop] + text[start:]


def _piece(text: str, rng: random.Random) -> tuple[int, int]:
    start = rng.randrange(len(text) + 1)
    return start, min(start + rng.choice((1, 4, 30, 300)), len(text))


def _number(text: str, rng: random.Random) -> str:
    return _replaced(text, rng, NUMBER, lambda _: rng.choice(NUMBERS))


def _word(text: str, rng: random.Random) -> str:
    place = rng.randrange(len(text) + 1)
    return text[:place] + rng.choice(WORDS).encode(errors="surrogatepass").decode("latin-1") + text[place:]


def _line(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    place = rng.randrange(len(lines))
    lines[place : place + 1] = rng.choice(([], [lines[place]] * 2, [rng.choice(lines), lines[place]]))
    return "\n".join(lines)


def _swap_keys(text: str, rng: random.Random) -> str:
    return _replaced(text, rng, KEY, lambda found: found.replace(KEY.match(found)[1], rng.choice(KEY.findall(text))))


def _element(text: str, rng: random.Random) -> str:
    return _replaced(text, rng, ELEMENT, lambda found: found * rng.choice((0, 2)))


def _replaced(text: str, rng: random.Random, pattern: re.Pattern[str], by: Callable[[str], str]) -> str:
    """One match of a pattern replaced; the same text where there is none."""
    found = list(pattern.finditer(text))
    if not found:
        return text
    at = rng.choice(found)
    return text[: at.start()] + by(at.group()) + text[at.end() :]


CASES = int(os.environ.get("FUZZ_CASES", "600"))
SEED = int(os.environ.get("FUZZ_SEED", "0"))

PATIENCE = 5.0
"""Processor time for a case [s]; a hundred times what most take."""

SCALED_SAMPLES = 500
"""A motion of more samples is read, but not scaled: that work is what was asked for."""

STUDY = """cell: cell.yaml
motion: lift.yaml
vary:
  robots.left.base.xyz[1]: {from: -0.2, to: 0.2}
  object.mass: {normal: {mean: 0.5, std: 0.1}}
  gravity[1]: [-9.8, -9.81]
  distance:
    sets:
      robots.left.base.xyz[0]: -1
      robots.right.base.xyz[0]: 2
    from: -0.1
    to: 0.1
  strength: {scales: [robots.left.torque, robots.right.torque], values: [1, 1.1]}
sample: sobol
count: 16
"""

GENERATED = ROOT / "generated" / "planar_dual_arm"


def read_cell(path):
    build_cell_model(path, CellDescription.read_file(path, "cell file"))


def read_motion(path):
    """A motion that can be read is scaled by the command line."""
    motion = mrts.load_motion(path)
    if len(motion.time) <= SCALED_SAMPLES:
        return main(["scale", str(GENERATED), str(path), "--json", "-"])
    return None


def read_study(path):
    """The first variants of a study that can be read are solved, and the last one."""
    study = mrts.read_study(path)
    "".join(map(str, study.parameters)).encode()
    solve_variants(study, 0, min(study.variants, 2))
    solve_variants(study, study.variants - 1, study.variants)


def finite(text):
    """What JSON text says, which holds no NaN and no infinity."""

    def refuse(name):
        raise AssertionError(f"{name} in an answer")

    return json.loads(text, parse_constant=refuse)


READERS = {
    "cell": ("cell.yaml", read_cell),
    "urdf": ("planar_arm.urdf", lambda path: read_cell(path.with_name("cell.yaml"))),
    "motion": ("lift.yaml", read_motion),
    "study": ("study.yaml", read_study),
    "waypoints": ("waypoints.yaml", read_motion),
    "object": ("object.csv", read_motion),
    "joints": ("joints.csv", read_motion),
    "result": ("result.npz", lambda path: finite(mrts.load_result(path).json_text()) and None),
    "manifest": ("generated/manifest.json", lambda path: read_generated(path.parent) and None),
    "bag": ("bag/bag.mcap", read_motion),
    "bag_description": ("bag/metadata.yaml", lambda path: mrts.load_motion(path.parent) and None),
}
"""By kind: a valid file, and what reads it."""


@pytest.fixture(scope="module")
def originals(planar_cell, tmp_path_factory):
    """Valid small files of every kind."""
    folder = tmp_path_factory.mktemp("originals")
    for path in DATA.iterdir():
        shutil.copy(path, folder)
    lift = (folder / "lift.yaml").read_text(encoding="utf-8").replace("samples: 101", "samples: 11")
    (folder / "lift.yaml").write_text(lift, encoding="utf-8")
    (folder / "waypoints.yaml").write_text(
        "duration: 1.0\nsamples: 11\nprofile: quintic\nwaypoints:\n"
        "  - {xyz: [1.25, 1.0, 0]}\n  - {xyz: [1.2, 1.1, 0], rpy: [0, 0, 0.1]}\n  - {xyz: [1.25, 1.2, 0]}\n",
        encoding="utf-8",
    )
    (folder / "study.yaml").write_text(STUDY, encoding="utf-8")
    motion = mrts.load_motion(folder / "lift.yaml")
    result = mrts.scale(planar_cell, motion)
    mrts.save_result(result, folder / "result.npz")
    mrts.write_trajectory_csv(result, folder / "joints.csv")
    mrts.write_ros_bag(result, folder / "bag")
    rows = [f"{t!r},{x!r},{y!r},0,0,0,0,1" for t, (x, y, _) in zip(motion.time, motion.position, strict=True)]
    table = "\n".join(["t,px,py,pz,qx,qy,qz,qw", *rows])
    (folder / "object.csv").write_text(table.replace("np.float64(", "").replace(")", ""), encoding="utf-8")
    shutil.copytree(GENERATED, folder / "generated")
    return folder


@pytest.mark.parametrize("kind", READERS)
def test_damaged_files_are_read_or_refused_in_a_sentence(kind, originals, tmp_path, capsys):
    name, read = READERS[kind]
    shutil.copytree(originals, tmp_path, dirs_exist_ok=True)
    path = tmp_path / name
    content = path.read_bytes()
    assert read(path) in (None, 0), "the file itself is valid"
    capsys.readouterr()
    refused = 0
    for seed in range(SEED, SEED + max(CASES // len(READERS), 1)):
        path.write_bytes(mutated(content, seed))
        start = time.process_time()
        try:
            code = read(path)
        except mrts.MrtsError as error:
            code, message = 2, str(error)
            assert message.isprintable(), (kind, seed, message)
            assert len(message) < 5000, (kind, seed)
        except Exception as error:
            raise AssertionError(f"{kind}, seed {seed}: {type(error).__name__}: {error}") from error
        captured = capsys.readouterr()
        assert time.process_time() - start < PATIENCE, (kind, seed)
        assert code in (None, 0, 1, 2), (kind, seed, code)
        assert "Traceback" not in captured.err, (kind, seed)
        assert captured.err.replace("\n", "").isprintable(), (kind, seed)
        assert "\n\n" not in captured.err, (kind, seed)
        refused += code == 2
        if code in (0, 1) and captured.out:
            finite(captured.out)
    assert CASES < 500 or refused > 0.2 * CASES / len(READERS)
