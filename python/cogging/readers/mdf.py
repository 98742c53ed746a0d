"""ASAM measurement data, version 2 to 4 (.mf4, .dat, .mdf), through asammdf."""

from __future__ import annotations

from typing import Any

from cogging.readers.request import Request


def _unit(channel: Any) -> str:
    """The unit of a channel, whose conversion may hold it instead."""
    return str(getattr(channel, "unit", "") or getattr(getattr(channel, "conversion", None), "unit", "") or "")


def read(request: Request) -> dict[str, Any]:
    """Read channels of one channel group; `time` is its master channel unless a channel bears that name.

    A channel that stands in several groups is called `GROUP.CHANNEL`, the group by its number.

    Raises:
        ImportError: asammdf is not installed.
        InputError: a channel is missing, or they stand in different groups. What a broken file raises is asammdf's.
    """
    from asammdf import MDF

    with MDF(request.path) as file:
        masters = set(file.masters_db.items())
        places: dict[str, tuple[int, int]] = {}
        counts = {name: len(entries) for name, entries in file.channels_db.items()}
        for name, entries in file.channels_db.items():
            for group, channel in entries:
                places[name if counts[name] == 1 else f"{group}.{name}"] = (group, channel)
        wants_master = "time" in (*request.names, *request.optional) and request.in_file("time") not in places
        if wants_master and "time" not in request.columns:
            others = tuple(name for name in request.names if name != "time")
            optional = tuple(name for name in request.optional if name != "time")
        else:
            wants_master, others, optional = False, tuple(request.names), tuple(request.optional)
        narrowed = Request(request.path, others, optional, request.columns, request.scaled, request.rows)
        names = [name for name, place in places.items() if place not in masters] if wants_master else list(places)
        units = [_unit(file.groups[group].channels[channel]) for group, channel in (places[name] for name in names)]
        chosen = {name: places[names[i]] for name, i in narrowed.choose(names, "file", units).items()}
        groups = {group for group, _ in chosen.values()}
        if len(groups) > 1:
            where = ", ".join(f"{name} in {group}" for name, (group, _) in chosen.items())
            raise request.refuse(f"columns: must stand in one channel group, of one time base, got {where}")
        columns: dict[str, Any] = {}
        for name, (group, channel) in chosen.items():
            signal = file.get(group=group, index=channel, ignore_invalidation_bits=True)
            columns[name] = signal.samples
            if signal.invalidation_bits is not None and signal.invalidation_bits.any():
                row = int(signal.invalidation_bits.argmax())
                raise request.refuse(f"row {row}: {name}: must be valid, got the invalidation bit")
        if wants_master:
            columns["time"] = file.get_master(next(iter(groups)))
        return columns
