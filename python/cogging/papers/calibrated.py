"""Values that the studies calibrated and the package ships as TOML files."""

from __future__ import annotations

import functools
import importlib.resources
from typing import Any

from cogging.files import parse_toml


@functools.cache
def shipped_toml(package: str, name: str) -> dict[str, Any]:
    """Return the content of a TOML file of cogging.papers or of a package in it."""
    return parse_toml(importlib.resources.files(package).joinpath(name).read_text(encoding="utf-8"))
