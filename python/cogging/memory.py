"""What calls take of memory by what they are given: compared with what is left before any of it is taken.

Sizes of work were measured as the growth of a process over the call: `python -m tests.attack.memory_peaks`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sized

from cogging import _core

NUMBER = 8  # bytes
LOG_COLUMNS = 8  # of a simulated log
MACHINE = 2500.0  # bytes of a drawn machine and its plant: 1350 to 1950 were seen
POINT = 36.0  # bytes of a point of a scan for each line of its spectrum: two complex tables, 26 to 33 were seen
#: Bytes of a row of a log, beside the log itself, and of a row for each parameter that is fitted.
ROW = {
    "audit": (500.0, 0.0),  # 441 were seen
    "identify": (1300.0, 70.0),  # 1840 of 10 parameters, 6500 of 82
    "diagnose": (8500.0, 0.0),  # 8010 and fewer
}


def require_rows(task: str, logs: Iterable[Sized], parameters: int = 0) -> None:
    """Refuse logs whose rows are too many for the tables that a task makes of them.

    Args:
        task: a key of ROW.
        logs: all that are looked at together.
        parameters: that are fitted.

    Raises:
        ValueError: names rows, rule and value.
    """
    rows = sum(len(log) for log in logs)
    row, parameter = ROW[task]
    size = row + parameter * parameters
    _core.require_memory("rows", rows * size, f"the tables of {task}, {size:.3g} bytes a row,", str(rows))


def require_machines(name: str, count: int, numbers: int) -> None:
    """Refuse more drawn machines than there is room for.

    Args:
        name: of the field that says how many.
        count: of machines.
        numbers: that are drawn of each.

    Raises:
        ValueError: names field, rule and value.
    """
    _core.require_memory(name, count * (MACHINE + 4 * NUMBER * numbers), f"{count} machines", str(count))


def require_table(name: str, rows: float, columns: float, copies: float = 1.0) -> None:
    """Refuse a table of numbers that there is no room for.

    Args:
        name: of the field that asks for the rows.
        rows, columns: of the table.
        copies: of it that are held at a time.

    Raises:
        ValueError: names field, rule and value.
    """
    told = f"{rows:.6g} rows of {columns:g} columns" + (f", {copies:g} times," if copies > 1.0 else "")
    _core.require_memory(name, NUMBER * rows * columns * copies, told, f"{rows:.6g}")
