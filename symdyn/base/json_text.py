"""JSON text of facts: any number becomes one that JSON has."""

from __future__ import annotations

import json
import math
from typing import Any


def json_text(facts: Any) -> str:
    """Indented, and with a newline. A number that is not finite is ``null``; a NumPy scalar is the plain one."""
    return json.dumps(plain(facts), indent=2, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """Facts of dicts, lists, text and numbers that every JSON can hold: finite ones, and none of NumPy's."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "item") and callable(value.item):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
