# SPDX-License-Identifier: MIT
"""A study on disk: `study.json` and one Parquet file a chunk of variants; needs the extra 'study' (pyarrow).

A part is there whole or not at all, and `study.json` fixes which variants it holds, so that a study that was ended at
any moment goes on where it stood: no row is lost or double.
"""

import fcntl
import hashlib
import json
import logging
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrts.base.arrays import Array
from mrts.base.atomic_file import told_of, write_atomically, write_text_atomically
from mrts.base.errors import InputError, as_path, require_extra
from mrts.base.input_file import read_text
from mrts.base.version import __version__
from mrts.limits.rows import limit_name
from mrts.studies.study import Study
from mrts.studies.variants import column_types

if TYPE_CHECKING:
    import pyarrow as pa

FORMAT = 3
"""Of study.json."""

STUDY_FILE = "study.json"
ROWS = "rows"
"""Folder of the parts, and of nothing else, as whatever reads Parquet wants it."""

LOCK_FILE = ".lock"
TEMPORARY_FILE = re.compile(r"\.(?:study|part-\d{8})\..*\.(?:json|parquet)")
"""What a writer that was killed leaves."""

MAX_RECORD_BYTES = 10**8
"""Of study.json: many more than lists of values take."""

UNITS = {"lower_time": "s", "upper_time": "s", "duration": "s", "clearance": "m"}
"""Of columns that are not parameters; c² has none."""

DIGEST_KEY = b"study"
"""In the metadata of a part: the digest of its study."""

logger = logging.getLogger("mrts")


@dataclass(frozen=True)
class StudyFolder:
    """A study and the part of its rows that is solved, in the folder `path`; `record` is what `study.json` holds."""

    path: Path
    record: Mapping[str, Any]

    @property
    def digest(self) -> str:
        """Hash of the whole study."""
        return str(self.record["digest"])

    @property
    def variants(self) -> int:
        """How many the study has, solved or not."""
        return int(self.record["variants"])

    @property
    def chunk(self) -> int:
        """Variants in a part; the last may have fewer."""
        return int(self.record["chunk"])

    @property
    def chunks(self) -> int:
        """How many parts a complete study has."""
        return -(-self.variants // self.chunk)

    @cached_property
    def schema(self) -> "pa.Schema":
        """Names and types of the columns, with their units."""
        import pyarrow as pa  # noqa: PLC0415 (an extra)

        fields = [
            pa.field(name, pa.type_for_alias(of["type"]), metadata={"unit": of["unit"]} if of["unit"] else None)
            for name, of in self.record["columns"].items()
        ]
        return pa.schema(fields, metadata={DIGEST_KEY: self.digest})

    def variants_of(self, number: int) -> range:
        """The variants of a chunk."""
        return range(number * self.chunk, min(self.variants, (number + 1) * self.chunk))

    def part(self, number: int) -> Path:
        """The file of a chunk."""
        return self.path / ROWS / f"part-{number:08d}.parquet"

    def parts(self) -> dict[int, Path]:
        """Files of the chunks that are solved, by number, in order."""
        files = ((number, self.part(number)) for number in range(self.chunks))
        return {number: path for number, path in files if path.exists()}

    def write(self, number: int, pieces: Sequence[Mapping[str, list[Any] | Array]]) -> None:
        """Write the rows of a chunk, whole or not at all.

        Args:
            number: Of the chunk.
            pieces: One after the other, each its columns by name; a NaN is no value.

        Raises:
            InputError: If the file cannot be written.
        """
        import pyarrow as pa  # noqa: PLC0415 (an extra)
        import pyarrow.parquet as pq  # noqa: PLC0415

        arrays = [[pa.array(piece[each.name], each.type, from_pandas=True) for each in self.schema] for piece in pieces]
        rows = pa.concat_tables([pa.Table.from_arrays(columns, schema=self.schema) for columns in arrays])

        def write(temporary: Path) -> None:
            with temporary.open("wb") as file:
                pq.write_table(rows, file, compression="zstd")
                file.flush()
                os.fsync(file.fileno())  # or a machine that loses power may keep the name without the content

        write_atomically(self.part(number), write)

    def table(self, columns: Sequence[str] | None = None) -> "pa.Table":
        """The rows that are solved, in the order of the variants.

        Args:
            columns: Names of those wanted; None takes all.

        Raises:
            InputError: If a part is damaged.
        """
        import pyarrow as pa  # noqa: PLC0415 (an extra)

        try:
            return self.dataset().to_table(columns=columns)
        except (pa.ArrowException, OSError) as error:
            rule = f"a part is damaged ({error}). The same mrts sweep into this folder solves it again."
            raise InputError(self.path, rule) from None

    def dataset(self) -> Any:
        """The rows that are solved as a `pyarrow.dataset.Dataset`, which reads what is asked for."""
        import pyarrow.dataset as ds  # noqa: PLC0415 (an extra)

        files = [str(path) for path in self.parts().values()]
        return ds.dataset(files, schema=self.schema, format="parquet")

    def drop_damaged(self) -> None:
        """Remove parts that are not what the study says; they will be solved again."""
        for number, path in self.parts().items():
            if not self._is_sound(path, len(self.variants_of(number))):
                logger.warning("%s is damaged, or of another study: solved again", path)
                path.unlink()

    def _is_sound(self, path: Path, length: int) -> bool:
        import pyarrow as pa  # noqa: PLC0415 (an extra)
        import pyarrow.parquet as pq  # noqa: PLC0415

        try:
            with pq.ParquetFile(path) as file:
                schema = file.schema_arrow
                return bool(file.metadata.num_rows == length and schema.equals(self.schema, check_metadata=True))
        except (pa.ArrowException, OSError):
            return False


def read_study_folder(path: Path | str) -> StudyFolder:
    """What a sweep has written so far; it may still be at work.

    Args:
        path: The folder that `mrts sweep -o` names.

    Raises:
        InputError: If it holds no study.
    """
    require_extra("study", "study", "pyarrow")
    folder = as_path("path", path)
    try:
        text = read_text(folder / STUDY_FILE, "file", MAX_RECORD_BYTES)
    except InputError as error:
        rule = f"holds no study: {STUDY_FILE}: {error.rule} Name what `mrts sweep -o` wrote."
        raise InputError(folder, rule) from None
    try:
        record = json.loads(text)
    except (ValueError, RecursionError):
        record = {"format": FORMAT}
    if not isinstance(record, dict) or record.get("format") != FORMAT:
        rule = f"is not a study of format {FORMAT}, which this mrts reads; name another folder."
        raise InputError(folder / STUDY_FILE, rule)
    if record.pop("check", None) != _check(record):
        raise InputError(folder / STUDY_FILE, "is damaged, or was changed by hand. Remove the folder, or name another.")
    return StudyFolder(folder, record)


def _check(record: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()


def study_content(study: Study) -> dict[str, Any]:
    """What `study.json` says of a study, as JSON values: all of it but the content of URDFs and tables."""
    units = {each.path: each.unit for each in study.parameters} | UNITS
    content = {
        "mrts": __version__,
        "digest": study.digest,
        "variants": study.variants,
        "columns": {name: {"type": kind, "unit": units.get(name, "")} for name, kind in column_types(study).items()},
        "study": {
            "file": study.path.name,
            "question": study.question.model_dump(),
            "sample": study.sample,
            "vary": [
                {"path": each.path, "unit": each.unit, "text": str(each), **asdict(each.distribution),
                 "targets": [asdict(target) for target in each.targets]}
                for each in study.parameters
            ],
            "seed": study.seed,
            "cell": study.cell,
            "motion": study.motion,
            "limits": list(map(limit_name, study.limits)),
            "files": {each.reference: f"SHA-256 {hashlib.sha256(each.content).hexdigest()}" for each in study.files},
        },
    }  # fmt: skip
    same: dict[str, Any] = json.loads(json.dumps(content))
    return same


@contextmanager
def opened_study_folder(path: Path, study: Study, chunk_size: Callable[[], int]) -> Iterator[StudyFolder]:
    """The folder of a study, begun or gone on with; nobody else writes into it meanwhile.

    Raises:
        InputError: If the folder holds something else, another sweep is at work in it, or it cannot be written.
    """
    require_extra("study", "study", "pyarrow")
    content = study_content(study)
    if not str(path).isprintable():  # pyarrow takes names in UTF-8 only
        raise InputError("folder", "must be the name of a folder in printable characters.", value=str(path))
    there = sorted(file.name for file in path.glob("[!.]*"))
    if there and STUDY_FILE not in there:
        raise InputError(path, f"holds no study, but {there[0]}: name a new or empty folder.")
    with _locked(path):
        for file in [*path.iterdir(), *(path / ROWS).glob("*")]:
            if TEMPORARY_FILE.fullmatch(file.name):
                file.unlink()
        if (path / STUDY_FILE).exists():
            folder = read_study_folder(path)
            _check_same(folder, content)
            folder.drop_damaged()
        else:
            record = {"format": FORMAT, "chunk": chunk_size(), **content}
            checked = json.dumps(record | {"check": _check(record)}, indent=1, ensure_ascii=False)
            write_text_atomically(path / STUDY_FILE, f"{checked}\n")
            folder = StudyFolder(path, record)
        yield folder


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Make a folder, and let no other sweep into it; the system forgets the lock of a process that is gone."""
    with told_of(path):
        path.mkdir(parents=True, exist_ok=True)
        file = (path / LOCK_FILE).open("a", encoding="utf-8")
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(path, "another sweep writes into it: let it end first.") from None
        except OSError as error:
            logger.warning("%s cannot be locked (%s): let no other sweep write into it", path, error.strerror)
        yield


def _check_same(folder: StudyFolder, content: Mapping[str, Any]) -> None:
    theirs, ours = (each["study"]["limits"] for each in (folder.record, content))  # of Python: no digest holds them
    if folder.digest == content["digest"] and theirs == ours:
        return
    before, now = ({"version of mrts": each["mrts"], **each["study"]} for each in (folder.record, content))
    changed = [name for name, value in now.items() if before.get(name) != value]
    what = ", ".join(changed) or "the table of its motion"
    rule = f"holds another study, which differs in {what}. Name another folder, or take back what was changed."
    raise InputError(folder.path, rule)
