"""MATLAB files: version 4 to 7 through scipy, 7.3 (HDF5) through h5py. A field of a struct is called `struct.field`."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from cogging.logs.readers.request import Request


def read(request: Request) -> dict[str, Any]:
    """Read variables of a version 4 to 7 file."""
    from scipy.io import loadmat, whosmat

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of scipy about duplicate names
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
        structs = sorted(name for name in roots if kinds[name] == "struct")  # which alone hide what is logical in them
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
    """The arrays in a struct, fields of structs in it included."""
    if not isinstance(value, np.ndarray) or value.dtype.names is None or value.size != 1:
        return {name: value}
    found: dict[str, Any] = {}
    for field in value.dtype.names:
        inner = value[field].flat[0]
        found.update(_fields(f"{name}.{field}", inner))
    return found


def read_hdf5(request: Request) -> dict[str, Any]:
    """Read variables of a version 7.3 file, or datasets of another HDF5 file; groups are structs."""
    import h5py

    from cogging.logs.readers.hdf5 import datasets, numbers_of

    with h5py.File(request.path, "r") as file:
        present = datasets(file, request)
        names = list(present)
        chosen = request.choose(names, "file")
        return {name: numbers_of(present[names[place]], name, request, len(chosen)) for name, place in chosen.items()}
