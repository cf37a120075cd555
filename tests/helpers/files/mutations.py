"""Seeded damage to input files: bytes, lines, numbers, keys, XML elements, and text that means something elsewhere.

See tests/base/test_mutated_inputs.py for what is done with it.
"""

import random
import re
from collections.abc import Callable

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
