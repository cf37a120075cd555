# SPDX-License-Identifier: MIT
"""Test vectors as rows of a C table."""

from collections.abc import Sequence

from mrts_codegen.embedded.c_literals import Precision, c_number, c_numbers

from mrts.base.embedded_inputs import EmbeddedMotors, EmbeddedVector


def vector_words(
    vectors: Sequence[EmbeddedVector],
    path_samples: int,
    precision: Precision,
    *,
    macro: str,
    motors: EmbeddedMotors | None,
) -> dict[str, str]:
    """What stands for each @WORD@ of the vectors' header.

    Args:
        vectors: The vectors.
        path_samples: The first so many of them are one motion with the nominal load.
        precision: Of the inputs; answers are in double.
        macro: What the library's constants begin with.
        motors: Of the cell; None where they are ideal.
    """
    fastest, changing = (max((abs(vector.inputs[k]).max() for vector in vectors), default=0.0) for k in (1, 2))
    rest = 0.0 if motors is None else motors.rest
    return {
        "VECTORS": str(len(vectors)),
        "PATH_SAMPLES": str(path_samples),
        "VECTOR_ROWS": "\n".join(_row(vector, precision, None if motors is None else macro) for vector in vectors),
        "REST_SPEED": c_number(rest * fastest, precision),
        "REST_ACCELERATION": c_number(rest * changing, precision),
    }


def _row(vector: EmbeddedVector, precision: Precision, macro: str | None) -> str:
    sample = ", ".join(f"{{{c_numbers(part.ravel(), precision)}}}" for part in vector.inputs)
    if macro is not None:
        sample += f", {macro}_{vector.place.upper()}"
    low, high, share_low, share_high = (c_number(end, "double") for end in (*vector.ends, *vector.share_ends))
    return (
        f"    {{{{{sample}}}, {c_number(vector.mass, precision)}, {vector.status}, {low}, {high}, "
        f"{vector.share_status}, {share_low}, {share_high}, {c_number(vector.c2, 'double')}, "
        f"{{{c_numbers(vector.torque, 'double')}}}}},"
    )
