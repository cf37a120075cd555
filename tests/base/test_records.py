"""Records refuse what pydantic refuses by the same annotations, at the same place."""

import json
import random
from copy import deepcopy
from typing import Annotated, Literal, Union, get_args, get_origin

import pytest
from pydantic import ConfigDict, Field, ValidationError, create_model

from mrts.base.errors import InputError, joined
from mrts.base.formats.record import Pose, Record, Rule, read_json
from mrts.base.manifest import FunctionRecord
from mrts.cell.record import Cylinder

pytestmark = pytest.mark.quick

TRIALS = 400
ZOO = (None, True, 0, 3, -1, 1.5, 1e13, "x", "a b", "a\n", "", [], {}, [1], [[1.0]], {"a": 1}, [None, "x"])


class TableRecord(Record):
    rows: list[str | None]
    limits: dict[str, tuple[float, float]]
    kind: Literal["tip", "base"]
    known: bool
    numbers: list[list[float]]


GIVEN = {
    Cylinder: {"radius": 1, "length": 2.5},
    FunctionRecord: {
        "symbol": "cell_terms", "instructions": 3, "inputs": {"q": [3, 4]},
        "outputs": {"E": [3, 1], "A": [3, 1]},
    },
    TableRecord: {
        "rows": ["fx", None], "limits": {"mass": [0.5, 2]}, "kind": "tip", "known": False, "numbers": [[1.0, 2], [3]],
    },
}  # fmt: skip


def spoiled(data, rng):
    """A copy with one entry, somewhere, exchanged, taken out or added."""
    data = deepcopy(data)
    place = data
    while True:
        key = rng.choice(list(place) if isinstance(place, dict) else range(len(place)))
        inner = place[key]
        if not (isinstance(inner, dict | list) and inner and rng.random() < 0.6):
            break
        place = inner
    kind = rng.random()
    if kind < 0.1 and isinstance(place, dict):
        del place[key]
    elif kind < 0.2 and isinstance(place, dict):
        place[key + "s"] = rng.choice(ZOO)
    else:
        place[key] = rng.choice(ZOO)
    return data


def place(detail):
    """Where pydantic finds an error."""
    key = ""
    for part in detail["loc"]:
        key = joined(key, f"[{part}]" if isinstance(part, int) else part)
    return key


def as_pydantic(kind):
    """A kind of a record's field, as pydantic has it."""
    if isinstance(kind, Rule):
        return Field(**{name: limit for name, limit in kind.limits.items() if name != "smallest"})
    if isinstance(kind, type) and issubclass(kind, Record):
        fields = {name: (as_pydantic(inner), getattr(kind, name, ...)) for name, inner in kind.model_fields.items()}
        config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
        return create_model(kind.__name__, __config__=config, **fields)
    parts = tuple(map(as_pydantic, get_args(kind)))
    if get_origin(kind) is Annotated:
        return Annotated[as_pydantic(kind.__origin__), *map(as_pydantic, kind.__metadata__)]
    if get_origin(kind) in {None, Literal}:
        return kind
    return Union[parts] if type(None) in parts else get_origin(kind)[parts]  # noqa: UP007 (as many as there are)


@pytest.mark.parametrize("record", GIVEN, ids=lambda record: record.__name__)
def test_pydantic_refuses_the_same(record):
    model = as_pydantic(record)
    rng = random.Random(record.__name__)  # noqa: S311 (draws of a test)
    refused = 0
    for data in [GIVEN[record], *(spoiled(GIVEN[record], rng) for _ in range(TRIALS))]:
        try:
            expected, details = model.model_validate_json(json.dumps(data)).model_dump(mode="json"), []
        except ValidationError as error:
            expected, details = None, error.errors()
        try:
            found, key = record.model_validate(data).model_dump(), None
        except InputError as error:
            found, key, refused = None, error.key, refused + 1
        assert found == expected
        assert key is None or any(place(detail).startswith(key) for detail in details), data
    assert TRIALS / 4 < refused < TRIALS


@pytest.mark.parametrize("text", ["", "[", "[1]", "3", "NaN", "[" * 100_000, '{"xyz": [NaN, 0, 0]}', "9" * 5000])
def test_what_is_no_json_of_a_record_is_refused(text):
    with pytest.raises(InputError):
        Pose.model_validate(read_json(text))
