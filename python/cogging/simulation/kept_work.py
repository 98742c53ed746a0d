"""Finished parts of a sweep or a tuning, kept beside its output until it is done, so that the same call continues."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import json
import os
import zlib
from collections.abc import Iterator, Mapping
from typing import Any

from cogging.effects.custom import Custom
from cogging.files import InputError, require_file
from cogging.model.model import Model
from cogging.outputs import AnyPath, target_of


class KeptWork:
    """Finished parts of a job, as JSON one a line, in the file `OUT.kept`; its first line is a digest of the job.

    Each line states its checksum: a damaged or unfinished one is left out, and its part is computed again. Nothing is
    kept without an output, or of a model with a custom effect, whose law cannot be compared.

    Attributes:
        parts: what an earlier call left.
    """

    def __init__(self, out: AnyPath | None, model: Model, asked: Mapping[str, Any]) -> None:
        """Read what an earlier call left; InputError: it was another job, or another version."""
        self.parts: list[Any] = []
        self._path, self._is_begun = None, False
        if out is None or any(isinstance(effect, Custom) for effect in model.effects):
            return
        whole = {"version": importlib.metadata.version("cogging"), "model": model.to_dict(), **asked}
        text = json.dumps(whole, sort_keys=True, default=lambda value: value.tolist())
        self._digest = hashlib.sha256(text.encode()).hexdigest().encode()
        target = target_of(out)
        self._path, self._called = target.with_name(f"{target.name}.kept"), f"{os.fspath(out)}.kept"
        if not os.path.lexists(self._path):
            return
        try:
            require_file(self._path, self._called)
            head, *lines = self._path.read_bytes().split(b"\n")
        except OSError as error:
            raise InputError(f"{self._called}: cannot be used: {error.strerror}") from None
        if head != self._digest and (lines or not self._digest.startswith(head)):
            rule = "holds the work of another call, or of another version: remove it, or write to another file"
            raise InputError(f"{self._called}: {rule}")
        if not lines:
            self._path.unlink()  # ended before its first part
        for checksum, _, part in (line.partition(b" ") for line in lines):
            if checksum == _checksum_of(part):
                self.parts.append(json.loads(part))

    def add(self, part: Any) -> None:
        """Append a finished part; InputError: the disk is full, and the earlier parts are kept."""
        if self._path is None:
            return
        text = json.dumps(part).encode()
        try:
            with open(self._path, "ab") as file:
                line = b"\n" + _checksum_of(text) + b" " + text
                file.write(line if file.tell() else self._digest + line)
        except OSError as error:
            raise InputError(f"{self._called}: cannot be written: {error.strerror}") from None
        self._is_begun = True

    def remove(self) -> None:
        """Remove the file: the job is done."""
        if self._path is not None:
            self._path.unlink(missing_ok=True)

    @contextlib.contextmanager
    def named_in_errors(self) -> Iterator[None]:
        """Let InputErrors of a block say where the finished work is."""
        try:
            yield
        except InputError as error:
            if not (self.parts or self._is_begun):
                raise
            kept = f"finished work is kept in {self._called}, the same call continues from there"
            raise InputError(f"{error}; {kept}") from error.__cause__


def _checksum_of(part: bytes) -> bytes:
    return b"%08x" % zlib.crc32(part)
