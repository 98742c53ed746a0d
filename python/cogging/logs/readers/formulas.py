"""No text of a file is evaluated: asammdf hands formulas to numexpr and sympy, which run them as Python."""

from __future__ import annotations

import sys
from typing import Any


class Formulas:
    """What keeps asammdf, where it is imported after this was made, from evaluating anything but its own texts.

    Attributes:
        refused: texts that were not evaluated.
    """

    def __init__(self) -> None:
        self.refused: list[str] = []
        sys.modules["sympy"] = None  # type: ignore[assignment]  # so that importing it fails
        try:
            import numexpr
        except ImportError:  # and asammdf says what it needs
            return
        evaluate, own = numexpr.evaluate, None

        def guarded(text: str, *arguments: Any, **named: Any) -> Any:
            nonlocal own
            own = _own_texts() if own is None else own
            if text not in own:
                self.refused.append(str(text)[:60])
                raise ValueError("a formula of a file is not evaluated")
            named.setdefault("local_dict", sys._getframe(1).f_locals)
            return evaluate(text, *arguments, **named)

        numexpr.evaluate = guarded


def _own_texts() -> set[str]:
    """The library's own: rational and polynomial laws of the parameters that a file holds as numbers."""
    from asammdf.blocks import v2_v3_constants, v4_constants

    texts = set()
    for constants in (v2_v3_constants, v4_constants):
        texts |= {value for name, value in vars(constants).items() if "CONV" in name and name.endswith("_TEXT")}
    return {text for text in texts if isinstance(text, str)}
