"""What a file may ask for, whoever wrote it: one place, of which `table` makes the one of docs/reading_files.md."""

from __future__ import annotations

from typing import NamedTuple

from cogging.files import DEEPEST, MOST_MARKS, MOST_TEXT

MIB = 1 << 20
HEADER = 1 << 18  # bytes of a text table in which its header row must stand
COLUMNS = 16384  # as many as a spreadsheet has
SMALL = 256 * MIB  # bytes of numbers that a small file may ask for
EXPANSION = 256  # bytes of numbers for each byte of a file: packed time that rises has never been seen beyond 50
COPIES = 4  # of its numbers that a library holds while it reads: twice were seen, three times of Parquet
LIBRARIES = 2048 * MIB  # bytes of addresses that a library takes without a file: 374 MiB were seen, of asammdf
ADDRESSES = 512 * MIB  # bytes of them that it may take beyond the memory that is left: they are not all in use
SECONDS = 30.0  # in which a small file must be read
BYTES_A_SECOND = 2e6  # slower is no reading


def numbers_most(size: int) -> int:
    """Bytes of numbers, 8 each, that a file of so many bytes may ask for."""
    return SMALL + EXPANSION * size


def memory_most(size: int, left: float) -> int:
    """Bytes of addresses that the process may take which reads such a file where so many bytes of memory are left."""
    return int(min(LIBRARIES + COPIES * numbers_most(size), ADDRESSES + left))


def seconds_most(size: int) -> float:
    """In which such a file must be read, s."""
    return SECONDS + size / BYTES_A_SECOND


class Limits(NamedTuple):
    """The limits of one format, in words."""

    format: str
    file: str
    columns: str
    numbers: str
    memory: str
    time: str


def limits() -> tuple[Limits, ...]:
    """Those of every format that is read."""
    from cogging._core import NumberReader  # readers of binary files do without the core

    mib = f"{SMALL // MIB} MiB + {EXPANSION} times the file"
    apart = f"{LIBRARIES // MIB} MiB + {COPIES} times the numbers, {ADDRESSES // MIB} MiB + what is free"
    time = f"{SECONDS:g} s + 1 s a {BYTES_A_SECOND / 1e6:g} MB"
    header = f"{COLUMNS}, header in {HEADER >> 10} KiB, line {NumberReader.LINE_MAX // MIB} MiB"
    binary = [
        Limits(name, "any", str(COLUMNS), mib, apart, time)
        for name in ("MATLAB 5 to 7", "MATLAB 7.3, HDF5", "ASAM MDF", "Parquet")
    ]
    toml = f"{MOST_MARKS} keys, tables and lists, {DEEPEST} in one another"
    return (
        Limits("CSV and other text", "any", header, "what is free", "the numbers", "none"),
        *binary,
        Limits("TOML", f"{MOST_TEXT // MIB} MiB", toml, "64 bits each", "what is free", "none"),
    )


def table() -> str:
    """The limits as a table of a document."""
    heads = ("format", "bytes of the file", "columns (TOML: tables)", "numbers asked, 8 bytes each", "memory", "time")
    rows = [heads, ("---",) * len(heads), *limits()]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


if __name__ == "__main__":
    print(table(), end="")
