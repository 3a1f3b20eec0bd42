"""The drive that the tests of this folder share."""

from __future__ import annotations

import pytest

from symdyn.compiler import robot_from_text
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import MODEL


@pytest.fixture(scope="session")
def robot() -> Robot:
    return robot_from_text(MODEL, "drive.toml")
