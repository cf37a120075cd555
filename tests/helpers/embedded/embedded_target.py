"""Exported libraries on a Cortex-M7 under QEMU: cross compilation with our own startup and linker script."""

import shutil
import subprocess
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent / "cortex_m7"
CPU = ["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"]
TOOLS = {"arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi", "qemu-system-arm": "qemu-system-arm"}
SECONDS = 300


def missing_tools():
    """Debian packages of the tools that are not here."""
    return [package for tool, package in TOOLS.items() if shutil.which(tool) is None]


def cross_compile(library: Path, main: Path, image: Path, *defines: str, flags=("-O2",)) -> Path:
    """Link a main program with an exported library into an image for the board."""
    sources = [FOLDER / "startup.c", main, *sorted((library / "src").glob("*.c"))]
    command = [shutil.which("arm-none-eabi-gcc"), *CPU, *flags, "-std=c99", "-ffp-contract=off", "-fno-common"]
    command += [*defines, f"-I{library / 'include'}", f"-I{library / 'tests'}", "-nostartfiles", "--specs=rdimon.specs"]
    command += ["-Wl,-T", str(FOLDER / "mps2.ld"), *map(str, sources), "-lm", "-o", str(image)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return image


def run_on_target(image: Path):
    """Run an image under QEMU; its exit code and what it printed. Instructions take 64 ns each."""
    command = [shutil.which("qemu-system-arm"), "-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "none"]
    command += ["-icount", "shift=6", "-semihosting-config", "enable=on,target=native", "-kernel", str(image)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=SECONDS)


def code_size(library: Path) -> int:
    """Bytes of code and constants of an exported library."""
    total = 0
    with tempfile.TemporaryDirectory() as folder:
        for source in sorted((library / "src").glob("*.c")):
            compiled = Path(folder) / f"{source.stem}.o"
            command = [shutil.which("arm-none-eabi-gcc"), *CPU, "-O2", "-std=c99", "-ffp-contract=off"]
            subprocess.run([*command, f"-I{library / 'include'}", "-c", str(source), "-o", str(compiled)], check=True)
            command = [shutil.which("arm-none-eabi-size"), "--format=berkeley", str(compiled)]
            text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            total += sum(int(number) for number in text.splitlines()[1].split()[:2])
    return total
