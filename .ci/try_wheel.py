# SPDX-License-Identifier: MIT
"""Build the wheel and use it without a checkout: in an empty environment and folder of each Python that is here.

With --own of this one alone.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

VERSIONS = ("3.11", "3.12", "3.13")
"""Of Python, that mrts says it works on."""

PLACES = (Path.home() / ".pyenv" / "versions",)
"""Where Pythons are kept apart, each in a folder of its version."""

COMMANDS = (
    ("demo", "-q", "-o", "example"),
    ("scale", "example/planar_dual_arm/cell.yaml", "example/planar_dual_arm/lift.yaml", "--save", "result.npz"),
    ("scale", "example/upper_body/cell.yaml", "example/upper_body/lift.yaml", "--profile", "optimal"),
    ("generate", "example/planar_dual_arm/cell.yaml", "-o", "generated"),
    ("export", "example/planar_dual_arm/cell.yaml", "-o", "embedded"),
)
"""What a first user does; each verb reads other files of the package."""


def pythons() -> list[Path]:
    """One interpreter a version, of those that start and can make environments; this one for its own version."""
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    found = []
    for version in VERSIONS:
        named = shutil.which(f"python{version}")
        kept = sorted(path for place in PLACES for path in place.glob(f"{version}.*/bin/python3"))
        candidates = [Path(sys.executable)] if version == own else [*([Path(named)] if named else []), *kept]
        found += [path for path in candidates if _makes_environments(path)][:1]
    return found


def _makes_environments(python: Path) -> bool:
    return subprocess.run([python, "-c", "import venv, ensurepip"], capture_output=True, check=False).returncode == 0


def run(*command: str | Path, cwd: Path) -> str:
    """What a command prints; it must succeed, with nothing of this checkout in its reach."""
    hidden = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "MRTS_CACHE_DIR")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    environment["MRTS_CACHE_DIR"] = str(cwd / "cache")
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}")
    return done.stdout


def try_wheel(python: Path, wheel: Path, folder: Path) -> str:
    """Install the wheel with nothing but what it asks for, and use it; the first line of an answer."""
    run(python, "-m", "venv", folder / "venv", cwd=folder)
    own = folder / "venv" / "bin"
    quiet = ("--quiet", "--disable-pip-version-check", "--no-compile")
    run(own / "python", "-m", "pip", "install", *quiet, "-c", ROOT / "constraints.txt", f"{wheel}[plot]", cwd=folder)
    where = run(
        own / "python", "-c", "import mrts, mrts_codegen; print(mrts.__file__, mrts_codegen.__file__)", cwd=folder
    )
    if not all(Path(path).is_relative_to(folder / "venv") for path in where.split()):
        sys.exit(f"the wheel is not what was imported: {where}")
    answers = [run(own / "mrts", *words, cwd=folder) for words in COMMANDS]
    return answers[1].splitlines()[0]


def main() -> None:
    """Build once, try with every Python."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # from a copy: a build leaves its own folders beside what it builds
        shutil.copytree(
            ROOT, folder / "source", ignore=shutil.ignore_patterns(".git", ".venv", "build", "*.egg-info", ".*_cache")
        )
        pip = (sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-deps")
        run(*pip, "-w", folder, folder / "source", cwd=folder)
        (wheel,) = folder.glob("mrts-*.whl")
        tried = [Path(sys.executable)] if "--own" in sys.argv else pythons()
        for place, python in enumerate(tried):
            (folder / str(place)).mkdir()
            version = run(python, "--version", cwd=folder).strip()
            print(f"{wheel.name} on {version}: {try_wheel(python, wheel, folder / str(place))}", flush=True)
        if not tried:
            sys.exit(f"no Python of {', '.join(VERSIONS)} makes environments here")


main()
