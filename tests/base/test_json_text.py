"""Facts become JSON whatever numbers they hold."""

from __future__ import annotations

import json

import numpy as np

from symdyn.base.json_text import json_text, plain


def test_numbers_of_numpy_and_those_that_are_not_finite() -> None:
    facts = {"yes": np.bool_(True), "count": np.int64(3), "size": np.float64(0.5), "all": (np.inf, -1.5, [np.nan])}
    read = json.loads(json_text(facts))
    assert read == {"yes": True, "count": 3, "size": 0.5, "all": [None, -1.5, [None]]}
    assert read["yes"] is True


def test_what_is_plain_stays() -> None:
    facts = {"text": "a", "none": None, "number": 1, "list": [1.5, {"deep": False}]}
    assert plain(facts) == facts
    assert json_text({"a": 1}) == '{\n  "a": 1\n}\n'
