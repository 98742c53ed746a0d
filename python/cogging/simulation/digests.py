"""Digest of a sweep or a tuning, by which an interrupted one recognises its finished work."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cogging.effects.custom import Custom
from cogging.model.model import Model


def digest_of(model: Model, asked: Mapping[str, Any]) -> str | None:
    """Return a digest of version, model and arguments; None with a custom effect, whose law cannot be compared."""
    if any(isinstance(effect, Custom) for effect in model.effects):
        return None
    whole = {"version": importlib.metadata.version("cogging"), "model": model.to_dict(), **asked}
    return hashlib.sha256(json.dumps(whole, sort_keys=True, default=_as_json).encode()).hexdigest()


def _as_json(value: Any) -> Any:
    return os.fspath(value) if isinstance(value, Path) else value.tolist()
