"""Mutations of files: bytes that differ, and tables with cells, headers and marks that no logger would write."""

import random

NUMBERS = (
    "nan", "inf", "-inf", "1e309", "-1e309", "1e300", "5e-324", "0x10", "1_000", "1,5", "1.2.3", "+-1", "", " ",
    "9" * 400, "\u0663", "1e", "e5", ".", "-", "true", "None", "=1+1", "@SUM(A1)", "\x00", "1\x1b[31m", "\u202e1",
)  # fmt: skip
WORDS = (
    "time", "position", "command", "", " time", "position [mm]", "command [mV]", "x" * 5000, "x" + " " * 5000 + "[",
    "x [" + " " * 5000 + "m", "position [\x1b[31m]", "\x1b]0;title\x07", "é", "\ud83d", "\u2028", "=cmd|' /C calc'!A0",
    "+time", "-time", "@time", "position\u202e", "reference", "nan", "1", '"', "a\tb",
)  # fmt: skip
SEPARATORS = (",", ";", "\t", " ", "|", "\0")
ENDS = ("\r\n", "\r", "\n\n", "\u2028")


def of_bytes(content: bytes, chance: random.Random) -> bytes:
    """A few bytes changed, removed, added or moved, or the end cut off."""
    made = bytearray(content)
    for _ in range(chance.choice((1, 1, 1, 2, 4, 16))):
        if not made:
            break
        at, other = chance.randrange(len(made)), chance.randrange(len(made))
        length = min(chance.choice((1, 1, 2, 4, 8, 64, 512)), len(made) - at)
        one, part, before, rest = slice(at, at + 1), slice(at, at + length), slice(at, at), slice(at, None)
        same, copied = chance.choice((b"\0", b"\xff", b"\x7f", b"\x80")) * length, made[other : other + length]
        ways = [(one, bytes([made[at] ^ 1 << chance.randrange(8)]))]
        ways += [(part, chance.randbytes(length)), (part, same), (part, b""), (part, copied)]
        ways += [(before, chance.randbytes(length)), (before, made[part]), (rest, b"")]
        where, new = chance.choice(ways)
        made[where] = new
    return bytes(made)


def of_table(content: bytes, chance: random.Random) -> bytes:
    """A text table with cells, rows, header, separators or ends of lines that are not as they should be."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    for _ in range(chance.choice((1, 1, 2, 5))):
        mutate_rows(rows, chance)
    mark, end = chance.choice((",",) * 5 + SEPARATORS), chance.choice(("\n",) * 5 + ENDS)
    text = end.join(mark.join(row) for row in rows) + chance.choice((end, ""))
    encoded = text.encode(chance.choice(("utf-8",) * 6 + ("utf-8-sig", "utf-16")), "surrogatepass")
    return of_bytes(encoded, chance) if chance.random() < 0.2 else encoded


def mutate_rows(rows: list[list[str]], chance: random.Random) -> None:
    """Change one cell, row or column in place."""
    header, row, cell, word = rows[0], chance.choice(rows), chance.choice(NUMBERS), chance.choice(WORDS)
    chance.choice(
        (
            lambda: row.__setitem__(chance.randrange(len(row)), cell) if row else None,
            lambda: header.__setitem__(chance.randrange(len(header)), word) if header else None,
            lambda: header.append(word),
            lambda: rows.insert(chance.randrange(len(rows)), row[:]),
            lambda: rows.pop() if len(rows) > 2 else None,
            lambda: row.append(cell),
            row.clear,
            lambda: chance.shuffle(rows),
            lambda: rows.insert(0, [word[:10]] * chance.choice((1, 3, 100_000))),
        )
    )()
