"""Bytes with something wrong in them, and tables whose words, sizes and values no logger would write."""

from __future__ import annotations

import random
from collections.abc import Callable

NUMBERS = (
    "nan", "inf", "-inf", "1e309", "-1e309", "1e300", "5e-324", "0x10", "1_000", "1,5", "1.2.3", "+-1", "", " ",
    "9" * 400, "\u0663", "1e", "e5", ".", "-", "true", "None", "=1+1", "@SUM(A1)", "\x00", "1\x1b[31m", "\u202e1",
)  # fmt: skip
WORDS = (
    "time", "position", "command", "", "time", " time", "position [mm]", "command [mV]", "x" * 5000,
    "x" + " " * 5000 + "[", "x [" + " " * 5000 + "m", "\x1b[2J", "é",
    "é", "=cmd|' /C calc'!A0", "+time", "-time", "@time", "position\u202e", "reference", "nan", "1", '"',
)  # fmt: skip
PARTS = (",", ";", "\t", " ", "|", "\0")


def of_bytes(content: bytes, chance: random.Random) -> bytes:
    """A few bytes other, away, more, moved, or the end cut off."""
    made = bytearray(content)
    for _ in range(chance.choice((1, 1, 1, 2, 4, 16))):
        size = len(made)
        if not size:
            break
        at = chance.randrange(size)
        length = min(chance.choice((1, 1, 2, 4, 8, 64, 512)), size - at)
        deed = chance.randrange(8)
        if deed == 0:
            made[at] ^= 1 << chance.randrange(8)
        elif deed == 1:
            made[at : at + length] = chance.randbytes(length)
        elif deed == 2:
            made[at : at + length] = chance.choice((b"\0", b"\xff", b"\x7f", b"\x80")) * length
        elif deed == 3:
            del made[at : at + length]
        elif deed == 4:
            made[at:at] = chance.randbytes(length)
        elif deed == 5:
            made[at:at] = made[at : at + length]
        elif deed == 6:
            other = chance.randrange(size)
            made[at : at + length] = made[other : other + length]
        else:
            del made[at:]
    return bytes(made)


def of_table(content: bytes, chance: random.Random) -> bytes:
    """A text table with cells, rows, header, marks or ends of lines that are not as they should be."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    deeds: tuple[Callable[[], object], ...] = (
        lambda: _cell(rows, chance, NUMBERS),
        lambda: _cell(rows, chance, NUMBERS),
        lambda: rows[0].__setitem__(chance.randrange(len(rows[0])), chance.choice(WORDS)) if rows[0] else None,
        lambda: rows[0].append(chance.choice(WORDS)),
        lambda: rows.insert(chance.randrange(len(rows)), chance.choice(rows)[:]),
        lambda: rows.pop(chance.randrange(1, len(rows))) if len(rows) > 2 else None,
        lambda: rows[chance.randrange(len(rows))].append(chance.choice(NUMBERS)),
        lambda: rows[chance.randrange(len(rows))].clear(),
        lambda: chance.shuffle(rows),
        lambda: rows.insert(0, _header(chance)),
    )
    for _ in range(chance.choice((1, 1, 2, 5))):
        chance.choice(deeds)()
    mark, end = chance.choice((",",) * 5 + PARTS), chance.choice(("\n",) * 5 + ("\r\n", "\r", "\n\n", "\u2028"))
    text = end.join(mark.join(row) for row in rows) + chance.choice((end, ""))
    encoded = text.encode(chance.choice(("utf-8",) * 6 + ("utf-8-sig", "utf-16")), "surrogatepass")
    return of_bytes(encoded, chance) if chance.random() < 0.2 else encoded


def _header(chance: random.Random) -> list[str]:
    word, count = chance.choice(WORDS), chance.choice((1, 3, 100_000))
    return [word if count < 100_000 else word[:10]] * count  # a megabyte: larger files tell no more


def _cell(rows: list[list[str]], chance: random.Random, words: tuple[str, ...]) -> None:
    row = rows[chance.randrange(1, len(rows))] if len(rows) > 1 else rows[0]
    if row:
        row[chance.randrange(len(row))] = chance.choice(words)
