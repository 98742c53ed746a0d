"""MATLAB files: version 4 to 7 through scipy, 7.3 (HDF5) through h5py. A field of a struct is named `struct.field`."""

from __future__ import annotations

import math
import os
import posixpath
import warnings
from typing import Any

import numpy as np

from cogging.logs.readers.column_request import Request

NUMBERS = "fiub"  # numpy kinds
DEEPEST = 32  # links on the way to a dataset, and nested virtual datasets


def read(request: Request) -> dict[str, Any]:
    """Return variables of a version 4 to 7 file."""
    from scipy.io import loadmat, whosmat

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # scipy warns of duplicate names
        listed = whosmat(request.path)
        kinds = {name: kind for name, _, kind in listed}
        wanted = {request.in_file(name) for name in (*request.names, *request.optional)}
        for name, shape, kind in listed:
            if name in wanted and kind == "logical":
                raise request.refuse(f"{name}: must be real numbers, got truth values")
            if name in wanted:
                size = math.prod(map(int, shape))
                request.require_room(name, size, float(size) * len(wanted & set(kinds)))
        roots = {name for name in kinds if name in wanted or kinds[name] == "struct"}
        variables = loadmat(request.path, variable_names=sorted(roots)) if roots else {}
        structs = sorted(name for name in roots if kinds[name] == "struct")  # only they hide logical values
        stated = loadmat(request.path, variable_names=structs, mat_dtype=True) if structs else {}
    present = {name: variables.get(name) for name, kind in kinds.items() if kind != "struct"}
    for name, kind in kinds.items():
        if kind == "struct":
            kept = _fields(name, stated.get(name))
            logical = {field: value for field, value in kept.items() if getattr(value, "dtype", "f8") == np.bool_}
            present.update(_fields(name, variables.get(name)) | logical)
    names = list(present)
    return {name: present[names[place]] for name, place in request.choose(names, "file").items()}


def _fields(name: str, value: Any) -> dict[str, Any]:
    """Return the arrays in a struct and in nested structs."""
    if not isinstance(value, np.ndarray) or value.dtype.names is None or value.size != 1:
        return {name: value}
    found: dict[str, Any] = {}
    for field in value.dtype.names:
        inner = value[field].flat[0]
        found.update(_fields(f"{name}.{field}", inner))
    return found


def read_hdf5(request: Request) -> dict[str, Any]:
    """Return variables of a version 7.3 file, or datasets of another HDF5 file; groups are structs.

    The format can refer to other files, whose content would pass as the log's: such links are refused.
    """
    import h5py

    with h5py.File(request.path, "r") as file:
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
        names = list(present)
        chosen = request.choose(names, "file")
        columns: dict[str, Any] = {}
        for name, item in ((name, present[names[place]]) for name, place in chosen.items()):
            if item.attrs.get("MATLAB_class", b"double") in (b"char", b"cell", b"logical"):
                raise request.refuse(f"{name}: must be real numbers, got {item.attrs['MATLAB_class'].decode()}")
            _require_own(item, name, request, DEEPEST)
            rows = item.size or 0  # None of an empty one
            request.require_room(name, rows, float(rows) * max(1.0, item.dtype.itemsize / 8.0) * len(chosen))
            # An empty array of its type refuses what holds no numbers.
            columns[name] = np.asarray(item[()]) if item.dtype.kind in NUMBERS else np.empty(0, dtype=item.dtype)
        return columns


def _require_own(item: Any, name: str, request: Request, depth: int) -> None:
    """Refuse a dataset whose numbers, or whose sources' numbers, are in another file."""
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
    """Return the item at a path, through links within the file; None if there is none."""
    import h5py

    for _ in range(DEEPEST):
        here, parts = file, [part for part in path.split("/") if part not in ("", ".")]
        for i, part in enumerate(parts):
            if not isinstance(here, h5py.Group) or not here.id.links.exists(os.fsencode(part)):
                return None
            links, key = here.id.links, os.fsencode(part)  # low level: `in` and `get` would follow links
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
