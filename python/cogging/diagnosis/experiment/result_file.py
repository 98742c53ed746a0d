"""Reading the JSON that `diagnose` wrote, and a plan, as files of a user."""

from __future__ import annotations

import json
import os
from typing import Any

from cogging.files import InputError, read_text


def read_json(path: str | os.PathLike[str], what: str) -> dict[str, Any]:
    """Read a JSON object.

    Args:
        path: of the file.
        what: it shall be, for the message.

    Raises:
        InputError: the file cannot be read, or is no JSON object.
    """
    text = read_text(path)
    try:
        document = json.loads(text, parse_constant=lambda word: None)
    except RecursionError:
        raise InputError(f"{path}: must be {what}, got lists or tables nested without end") from None
    except ValueError as error:
        raise InputError(f"{path}: must be {what} (JSON): {error}") from None
    if not isinstance(document, dict):
        raise InputError(f"{path}: must be {what}, got a {type(document).__name__}")
    return document


def read_result(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read what `diagnose --json` wrote.

    Raises:
        InputError: the file cannot be read, or is no such result.
    """
    document = read_json(path, "the result of diagnose --json")
    if "verdict" not in document or "effects" not in document:
        raise InputError(f"{path}: must be the result of diagnose --json, got no verdict and effects")
    return document
