"""Digest of a sweep or a tuning, by which an interrupted one recognises its finished work."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
from collections.abc import Mapping
from typing import Any

from cogging.effects.custom import Custom
from cogging.model.model import Model


def digest_of(model: Model, asked: Mapping[str, Any]) -> str | None:
    """Return a digest of version, model and arguments; None with a custom effect, whose law cannot be compared."""
    if any(isinstance(effect, Custom) for effect in model.effects):
        return None
    whole = {"version": importlib.metadata.version("cogging"), "model": model.to_dict(), **asked}
    text = json.dumps(whole, sort_keys=True, default=lambda value: value.tolist())
    return hashlib.sha256(text.encode()).hexdigest()
