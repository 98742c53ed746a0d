"""ASAM measurement data, version 2 to 4 (.mf4, .dat, .mdf), through asammdf."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

from cogging.files import InputError
from cogging.logs.readers.column_request import Request

#: Conversions of numbers to numbers, by the library's codes. Those of value ranges to texts may contain others.
NUMBERS = {3: (65535, 0, 1, 2, 6, 7, 8, 9), 4: (0, 1, 2, 4, 5)}
RANGES = 6  # value ranges to numbers, version 4; the library is wrong for integers
FLOATS = (4, 5)  # data types of version 4
VALUES_TO_TEXTS = {3: (11, 12), 4: (7, 8)}
FORMULA = {3: 10, 4: 3}
OF_TIME = (65535, 0)  # conversions that the library applies to the time of version 2 and 3: none and linear


def refuse_formulas() -> list[str]:
    """Prevent asammdf, imported later, from evaluating formulas of a file; the list returned gets those it asks for.

    It passes formulas to numexpr and sympy, which run them as Python. Only its own formulas are evaluated.
    """
    refused: list[str] = []
    sys.modules["sympy"] = None  # type: ignore[assignment]  # so that importing it fails
    try:
        import numexpr
    except ImportError:  # and asammdf says what it needs
        return refused
    evaluate = numexpr.evaluate

    def guarded(text: str, *arguments: Any, **named: Any) -> Any:
        from asammdf.blocks import v2_v3_constants, v4_constants

        known = {**vars(v2_v3_constants), **vars(v4_constants)}  # rational and polynomial conversions among them
        if text not in [known[name] for name in known if "CONV" in name and name.endswith("_TEXT")]:
            refused.append(str(text)[:60])
            raise ValueError("a formula of a file is not evaluated")
        named.setdefault("local_dict", sys._getframe(1).f_locals)
        return evaluate(text, *arguments, **named)

    numexpr.evaluate = guarded
    return refused


def read(request: Request) -> dict[str, Any]:
    """Return channels of one channel group; `time` is its master channel unless a channel has that name.

    A channel that occurs in several groups is named `GROUP.CHANNEL`, with the number of the group.
    """
    formulas = refuse_formulas()  # before asammdf imports numexpr
    from asammdf import MDF

    plain: dict[str, Any] = {"process_bus_logging": False}  # it would open attachments
    with MDF(request.path, **plain) as file:
        places = {
            name if len(entries) == 1 else f"{group}.{name}": (group, channel)
            for name, entries in file.channels_db.items()
            for group, channel in entries
        }
        asked = "time" in (*request.names, *request.optional) and "time" not in request.columns
        wants_master = asked and request.in_file("time") not in places
        others, names = request, list(places)
        if wants_master:
            masters = set(file.masters_db.items())
            wanted, optional = ([n for n in given if n != "time"] for given in (request.names, request.optional))
            others = replace(request, names=wanted, optional=optional)
            names = [name for name, place in places.items() if place not in masters]
        channels = [file.groups[group].channels[channel] for group, channel in (places[name] for name in names)]
        of_conversions = [getattr(getattr(channel, "conversion", None), "unit", "") for channel in channels]
        units = [str(getattr(c, "unit", "") or unit or "") for c, unit in zip(channels, of_conversions, strict=True)]
        chosen = {name: places[names[i]] for name, i in others.choose(names, "file", units).items()}
        groups = {group for group, _ in chosen.values()}
        if len(groups) > 1:
            where = ", ".join(f"{name} in {group}" for name, (group, _) in chosen.items())
            raise request.refuse(f"columns: must stand in one channel group, of one time base, got {where}")
        version = 4 if str(file.version) >= "4" else 3
        for name, (group, channel) in chosen.items():
            _require_numbers(request, name, file.groups[group].channels[channel], version)
        for group in groups:
            _require_time(request, file, group, version)
            stated = file.groups[group].channel_group
            record = getattr(stated, "samples_byte_nr", 0) + getattr(stated, "invalidation_bytes_nr", 0)
            cycles, columns = int(stated.cycles_nr), len(chosen) + wants_master
            request.require_room("cycles", cycles, float(cycles) * max(float(columns), record / 8.0))
        found = {}
        for name, (group, channel) in chosen.items():
            signal = file.get(group=group, index=channel, ignore_invalidation_bits=True)
            if signal.invalidation_bits is not None and signal.invalidation_bits.any():
                row = int(signal.invalidation_bits.argmax())
                raise request.refuse(f"row {row}: {name}: must be valid, got the invalidation bit")
            found[name] = signal.samples
        if wants_master:
            found["time"] = file.get_master(next(iter(groups)))
        if formulas:
            raise request.refuse(f"conversion: must not be a formula in the file, got {formulas[0]!r}")
        return found


def _require_time(request: Request, file: Any, group: int, version: int) -> None:
    """Refuse a group whose time is not a linear conversion of numbers in the file."""
    if group not in file.masters_db:
        return
    master = file.groups[group].channels[file.masters_db[group]]
    name = f"time ({master.name})"
    _require_numbers(request, name, master, version)
    if version == 3 and master.conversion is not None and master.conversion.conversion_type not in OF_TIME:
        raise request.refuse(f"{name}: must be converted linearly, got conversion {master.conversion.conversion_type}")


def _require_numbers(request: Request, name: str, channel: Any, version: int) -> None:
    """Refuse a channel whose conversion is absent, a formula, or not one of numbers: its values would be raw counts."""
    if channel.conversion is None:
        if getattr(channel, "conversion_addr", 0):
            raise request.refuse(f"{name}: must have a whole conversion, got one that cannot be read")
        return
    if version == 4 and channel.conversion.conversion_type == RANGES and channel.data_type in FLOATS:
        return
    _require_conversion(request, name, channel.conversion, version)


def _require_conversion(request: Request, name: str, conversion: Any, version: int) -> None:
    kind = conversion.conversion_type
    if kind == FORMULA[version]:
        raise _formula(request, name, conversion.formula)
    if kind in VALUES_TO_TEXTS[version]:
        for inner in (getattr(conversion, "referenced_blocks", None) or {}).values():
            if hasattr(inner, "conversion_type"):
                _require_conversion(request, name, inner, version)
            elif isinstance(inner, bytes) and version == 3 and b"{X}" in inner:
                raise _formula(request, name, inner.decode("latin-1"))
    elif kind not in NUMBERS[version]:
        rule = "must have a conversion of numbers to numbers that is read rightly"
        raise request.refuse(f"{name}: {rule}, got number {kind} of MDF {version}")


def _formula(request: Request, name: str, text: str) -> InputError:
    said = str(text).strip(" \0")[:60]
    return request.refuse(f"{name}: must be converted without a formula, which is not evaluated, got {said!r}")
