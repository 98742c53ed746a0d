"""What an HDF5 file itself holds: the format can name other files, whose content would pass as the log's."""

from __future__ import annotations

import os
import posixpath
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.logs.readers.request import Request

NUMBERS = "fiub"  # kinds of numpy
DEEPEST = 32  # links on the way to a dataset, and virtual datasets of virtual datasets


def datasets(file: Any, request: Request) -> dict[str, Any]:
    """The datasets of an open file by name, `group.dataset`, those behind links included that the request asks for."""
    import h5py

    present: dict[str, Any] = {}

    def visit(name: str, item: Any) -> None:  # follows no links
        if isinstance(item, h5py.Dataset) and not name.startswith("#"):
            present[name.replace("/", ".")] = item

    file.visititems(visit)
    for name in (*request.names, *request.optional):
        there = request.in_file(name)
        if there not in present:
            item = _followed(file, "/" + there.replace(".", "/"), there, request)
            if isinstance(item, h5py.Dataset):
                present[there] = item
    return present


def numbers_of(item: Any, name: str, request: Request, columns: int) -> npt.NDArray[Any]:
    """The content of a dataset, one of so many columns; an empty array of its kind where that is none of numbers."""
    if item.attrs.get("MATLAB_class", b"double") in (b"char", b"cell", b"logical"):
        raise request.refuse(f"{name}: must be real numbers, got {item.attrs['MATLAB_class'].decode()}")
    _require_own(item, name, request, DEEPEST)
    rows = item.size or 0  # none of an empty one
    request.require_room(name, rows, float(rows) * max(1.0, item.dtype.itemsize / 8.0) * columns)
    return np.asarray(item[()]) if item.dtype.kind in NUMBERS else np.empty(0, dtype=item.dtype)


def _require_own(item: Any, name: str, request: Request, depth: int) -> None:
    """Refuse a dataset whose numbers stand in another file, or make one of those that do."""
    import h5py

    if item.external:
        raise request.refuse(f"{name}: must be numbers in this file, got external storage in {item.external[0][0]!r}")
    for source in item.virtual_sources() if item.is_virtual else ():
        if source.file_name != ".":
            raise request.refuse(f"{name}: must be numbers in this file, got a virtual dataset of {source.file_name!r}")
        if depth == 0:
            raise request.refuse(f"{name}: must be a dataset, got more than {DEEPEST} virtual ones in each other")
        inner = _followed(item.file, posixpath.join("/", source.dset_name), name, request)
        if isinstance(inner, h5py.Dataset):
            _require_own(inner, name, request, depth - 1)


def _followed(file: Any, path: str, name: str, request: Request) -> Any:
    """The item at a path, through links within the file; None if there is none."""
    import h5py

    for _ in range(DEEPEST):
        here, parts = file, [part for part in path.split("/") if part not in ("", ".")]
        for i, part in enumerate(parts):
            if not isinstance(here, h5py.Group) or not here.id.links.exists(os.fsencode(part)):
                return None
            links, key = here.id.links, os.fsencode(part)  # of the group itself: its own `in` and `get` follow links
            kind = links.get_info(key).type
            if kind == h5py.h5l.TYPE_EXTERNAL:
                other = os.fsdecode(links.get_val(key)[0])
                raise request.refuse(f"{name}: must be numbers in this file, got a link to {other!r}")
            if kind == h5py.h5l.TYPE_SOFT:
                path = posixpath.join(here.name, os.fsdecode(links.get_val(key)), *parts[i + 1 :])
                break
            here = here[part]
        else:
            return here
    raise request.refuse(f"{name}: must be a dataset, got more than {DEEPEST} links on the way to it")
