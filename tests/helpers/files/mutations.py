"""Seeded damage to input files: bytes, lines, numbers, keys, XML elements, and text that means something elsewhere.

See tests/base/test_mutated_inputs.py for what is done with it.
"""

import random
import re

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
    """A damaged copy.

    Args:
        content: Of a valid file.
        seed: The same seed does the same damage.
    """
    rng = random.Random(seed)  # noqa: S311 (not for secrets)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        content = rng.choice((_flip, _cut, _twice, _number, _number, _word, _line, _swap_keys, _element))(content, rng)
    return content


def _flip(content: bytes, rng: random.Random) -> bytes:
    damaged = bytearray(content)
    for _ in range(rng.choice((1, 1, 8))):
        if damaged:
            damaged[rng.randrange(len(damaged))] = rng.randrange(256)
    return bytes(damaged)


def _cut(content: bytes, rng: random.Random) -> bytes:
    start, stop = _piece(content, rng)
    return content[:start] if rng.random() < 0.3 else content[:start] + content[stop:]


def _twice(content: bytes, rng: random.Random) -> bytes:
    start, stop = _piece(content, rng)
    return content[:stop] + content[start:]


def _piece(content: bytes, rng: random.Random) -> tuple[int, int]:
    start = rng.randrange(len(content) + 1)
    return start, min(start + rng.choice((1, 4, 30, 300)), len(content))


def _number(content: bytes, rng: random.Random) -> bytes:
    return _replaced(content, NUMBER, rng, rng.choice(NUMBERS))


def _word(content: bytes, rng: random.Random) -> bytes:
    text = content.decode("latin-1")
    place = rng.randrange(len(text) + 1)
    word = rng.choice(WORDS).encode(errors="surrogatepass").decode("latin-1")
    return (text[:place] + word + text[place:]).encode("latin-1")


def _line(content: bytes, rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    place = rng.randrange(len(lines))
    lines[place : place + 1] = rng.choice(([], [lines[place]] * 2, [rng.choice(lines), lines[place]]))
    return b"\n".join(lines)


def _swap_keys(content: bytes, rng: random.Random) -> bytes:
    keys = KEY.findall(content.decode("latin-1")) or ["key"]
    found = list(KEY.finditer(content.decode("latin-1")))
    if not found:
        return content
    at = rng.choice(found)
    text = content.decode("latin-1")
    return (text[: at.start(1)] + rng.choice(keys) + text[at.end(1) :]).encode("latin-1")


def _element(content: bytes, rng: random.Random) -> bytes:
    text = content.decode("latin-1")
    found = list(ELEMENT.finditer(text))
    if not found:
        return content
    at = rng.choice(found)
    return (text[: at.start()] + at.group() * rng.choice((0, 2)) + text[at.end() :]).encode("latin-1")


def _replaced(content: bytes, pattern: re.Pattern[str], rng: random.Random, by: str) -> bytes:
    text = content.decode("latin-1")
    found = list(pattern.finditer(text))
    if not found:
        return content
    at = rng.choice(found)
    return (text[: at.start()] + by + text[at.end() :]).encode("latin-1")
