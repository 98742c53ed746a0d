"""Text tables: columns separated by comma, semicolon, tab or blanks, with a header row."""

from __future__ import annotations

import contextlib
import csv
import os
import re
import sys
from collections.abc import Iterator, Sequence
from typing import IO

from tqdm import tqdm

from cogging._core import NumberReader, require_memory
from cogging.arrays import FloatArray
from cogging.files import InputError, reading
from cogging.logs.readers.column_request import Request, split_unit

HEADER = 1 << 18  # bytes that contain the header row
BLOCK = 1 << 22  # bytes read at once
HEAD_LINES = 200
ROWS_ALIKE = 3  # consecutive lines of equally many numbers that begin a table
LARGE = 100 << 20  # bytes from which a progress bar is shown
SEPARATORS = (";", ",", "\t")
DECIMAL_COMMAS = "decimal commas"  # note
SHOWN = 40  # characters of a line in a message
DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d*(?:[eE][+-]?\d+)?")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")  # or a decimal comma before three digits
WHOLE = re.compile(r"[+-]?\d+(?:[eE][+-]?\d+)?")


def read(request: Request) -> dict[str, FloatArray]:
    """Return columns of a text table (see columns.read_columns)."""
    with _opened(request) as file:
        size = os.fstat(file.fileno()).st_size
        head = file.read(HEADER)
        reader, index, first_data = _reader(head, size, request)
        above = head.split(b"\n", first_data)  # the lines above the data, and the rest
        file.seek(sum(len(text) + 1 for text in above[:first_data]) if len(above) > first_data else len(head))
        shown = size >= LARGE and sys.stderr.isatty()
        with tqdm(total=size, unit="B", unit_scale=True, desc=str(request.path), disable=not shown, leave=False) as bar:
            while not reader.done and (block := file.read(BLOCK)):
                reader.feed(block)
                bar.update(len(block))
        reader.finish()
    arrays = dict(zip(sorted(set(index.values())), reader.take(), strict=True))
    return {name: arrays[place] for name, place in index.items()}


def survey(request: Request) -> None:
    """Fill the request's survey with the names and units of all columns."""
    with _opened(request) as file:
        head = file.read(HEADER)
        _, labels, units, first_data = _find_header(_lines(head, request), request)
    if labels and all(map(_is_number, labels)):
        rule = "must be a header row with the names of the columns"
        raise request.refuse(f"line {first_data}: {rule}, got numbers: write one above them, time,position,command")
    request.choose(labels, "header", units)


@contextlib.contextmanager
def _opened(request: Request) -> Iterator[IO[bytes]]:
    """Open the file; an error of the system or of the core names it."""
    with reading(request.path), open(request.path, "rb") as file:
        try:
            yield file
        except (InputError, UnicodeDecodeError):
            raise
        except ValueError as error:
            raise request.refuse(str(error)) from None


def _reader(head: bytes, size: int, request: Request) -> tuple[NumberReader, dict[str, int], int]:
    """Return the reader of the columns in the order of the file, their places, and the first data line."""
    lines = _lines(head, request)
    separator, labels, units, first_data = _find_header(lines, request)
    index = request.choose(labels, "header", units)
    labelled = {place: name for name, place in reversed(index.items())}  # two names for one column: read once
    wanted, rows = sorted(labelled), request.rows
    kept = lines[first_data:]
    decimal = _decimal(kept, separator, index, len(labels), first_data + 1, request)
    if decimal == ",":
        request.notes.append(DECIMAL_COMMAS)
    mean = (sum(map(len, kept)) / len(kept) + 1) if kept else 1.0
    limit = size if rows.stop is None else min(size, int((rows.stop - (rows.start or 0)) * mean))
    expected = int(1.1 * limit / mean) + 16
    table = f"about {limit / mean:.3g} rows of {len(wanted)} columns"
    require_memory("rows", 8.0 * expected * len(wanted), table, f"{size} bytes")
    reader = NumberReader(
        separator=separator,
        fields=len(labels),
        wanted=wanted,
        labels=[labelled[place] for place in wanted],
        first_row=rows.start or 0,
        end_row=rows.stop,
        first_line=first_data + 1,
        expected_rows=expected,
        decimal=decimal,
    )
    return reader, index, first_data


def _decimal(lines: list[str], separator: str, index: dict[str, int], fields: int, first: int, request: Request) -> str:
    """Return the decimal mark, a point or a comma, from the first rows; any column may show that a comma is one."""
    comma = point = ""
    sure = False
    cells = _split(lines[0], separator) if separator == "," and lines else []
    if fields < len(cells) <= 2 * fields and all(WHOLE.fullmatch(cell) for cell in cells):
        # Rows of more integers than the header has columns: decimal commas between commas.
        rule = f"must have {fields} columns as the header, got {len(cells)} columns"
        advice = "numbers with decimal commas need semicolons or tabs between the columns"
        raise request.refuse(f"line {first}: {rule}: {advice}")
    for number, line in enumerate(lines, start=first):
        commas = "," in line and (separator != "," or '"' in line)
        if not commas and (point or "." not in line):
            continue
        cells = _split(line, separator)
        sure = sure or any(DECIMAL_COMMA.fullmatch(cell) and not THOUSANDS.fullmatch(cell) for cell in cells)
        for cell in (cells[place] for place in index.values() if place < len(cells)):
            if DECIMAL_COMMA.fullmatch(cell) or THOUSANDS.fullmatch(cell):
                comma = comma or cell
            elif "." in cell and _is_number(cell):
                point = point or cell
        if comma and point:
            rule = "must have one decimal mark in all numbers"
            raise request.refuse(f"line {number}: {rule}, got {comma[:SHOWN]!r} and {point[:SHOWN]!r}")
    if comma and not sure:
        rule = "must show whether a comma is a decimal mark or parts thousands: write a decimal point"
        raise request.refuse(f"line {first}: {rule}, got numbers like {comma[:SHOWN]!r} alone")
    return "," if comma else "."


def _lines(head: bytes, request: Request) -> list[str]:
    """Return the lines of the file's beginning without a last one that may be incomplete."""
    whole = len(head) < HEADER
    if b"\0" in head:
        raise request.refuse(f"must be UTF-8 text, got a zero at byte {head.index(0)}")
    try:
        text = head.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if whole or error.start < len(head) - 4:
            raise
        text = head[: error.start].decode("utf-8-sig")
    if "\r" in text.replace("\r\n", "") and "\n" not in text:
        raise request.refuse("line 1: must end with LF or CR LF, got a lone CR")
    lines = text.split("\n")
    if lines and (not lines[-1] or not whole):
        lines.pop()
    if not whole and not lines:
        raise request.refuse(f"must have its header row in the first {HEADER} bytes, got a first line that is longer")
    return [line.rstrip("\r") for line in lines]


def _split(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.replace("\t", " ").split()
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a cell beyond the limit of the module
        cells = line.split(separator)
    fields = [cell.strip() for cell in cells]
    while fields and not fields[-1]:
        fields.pop()
    return fields


def _require_whole_quotes(line: str, separator: str, number: int, request: Request) -> None:
    """Refuse quotes that do not close, or have text behind them, as the core does in rows."""
    line = line.replace("\t", " ") if separator == " " else re.sub(rf'"[ \t]+(?={separator}|$)', '"', line)
    try:
        next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True), None)
    except csv.Error as error:
        if "limit" not in str(error):  # a long cell
            rule = "close its quotes" if "end of data" in str(error) else "have a separator behind closed quotes"
            raise request.refuse(f"line {number}: must {rule}, got {line[:SHOWN]!r}") from None


def _separator(line: str, below: Sequence[str] = ()) -> str:
    """Return the separator of columns: one that is as frequent in the lines below, a comma last."""
    outside, *others = ("".join(text.split('"')[::2]) for text in (line, *below))
    known = [mark for mark in SEPARATORS if mark in outside]
    shared = [m for m in known if others and all(outside.count(m) == other.count(m) for other in others)]
    if shared:
        return next((mark for mark in shared if mark != ","), ",")
    return max(known, key=outside.count, default=" ")


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _find_header(lines: list[str], request: Request) -> tuple[str, list[str], list[str] | None, int]:
    """Return separator, names, the units in a row below, and the first data line."""
    candidates = [i for i, line in enumerate(lines[:HEAD_LINES]) if line.strip()]
    best = _header_line(lines, candidates, request)
    if best is None:
        request.choose([], "header")
        raise request.refuse("rows: must be at least 1, got 0")  # every wanted column was optional
    separator = _separator(lines[best], lines[best + 1 : best + 3])
    _require_whole_quotes(lines[best].lstrip("#% "), separator, best + 1, request)
    labels = _split(lines[best].lstrip("#% "), separator)
    below = [i for i in candidates if i > best]
    if below:
        units = _split(lines[below[0]], separator)
        if any(units) and len(units) <= len(labels) and not any(map(_is_number, units)) and len(below) > 1:
            _require_whole_quotes(lines[below[0]], separator, below[0] + 1, request)
            return separator, labels, units + [""] * (len(labels) - len(units)), below[0] + 1
    return separator, labels, None, best + 1


def _header_line(lines: list[str], candidates: list[int], request: Request) -> int | None:
    """Return the line with the wanted names, or the one before the first row of numbers, or the first."""
    if request.survey is not None:
        return _line_above_rows(lines, candidates)
    wanted = {request.in_file(name) for name in request.names}
    before = None
    for k, i in enumerate(candidates):
        fields = _fields(lines, i)
        if wanted <= {text for field in fields for text in (field, split_unit(field)[0])}:
            return i
        if len(fields) > 1 and all(map(_is_number, fields)) and before is None and k > 0:
            before = candidates[k - 1]
    return before if before is not None else next(iter(candidates), None)


def _line_above_rows(lines: list[str], candidates: list[int]) -> int | None:
    """Return the line of names above the first rows of mostly numbers, a row of units skipped; or the first line."""
    like_rows = []
    for i in candidates:
        fields = _fields(lines, i)
        numbers = sum(map(_is_number, fields))
        like_rows.append(len(fields) if numbers > 1 and 2 * numbers >= len(fields) else 0)
    for k, count in enumerate(like_rows):
        if count and set(like_rows[k : k + ROWS_ALIKE]) == {count}:
            last = candidates[max(k - 1, 0)]
            if k < 2:
                return last
            names, units = _fields(lines, candidates[k - 2]), _fields(lines, last)
            has_units = 1 < len(units) == len(names) and not any(map(_is_number, names))
            return candidates[k - 2] if has_units else last
    return next(iter(candidates), None)


def _fields(lines: list[str], line: int) -> list[str]:
    return _split(lines[line].lstrip("#% "), _separator(lines[line], lines[line + 1 : line + 3]))
