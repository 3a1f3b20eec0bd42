"""What every table reader returns: columns of finite numbers, and where each row stands in the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class RawTable:
    """Numbers as in the file, without units, and the digest of the file they came from.

    ``values`` maps a column's name to (N,) finite float64; ``positions`` gives its 1-based number
    in the file; ``lines`` (N,) holds the 1-based line of each row (a format without lines counts
    rows).
    """

    values: Mapping[str, NDArray[np.float64]]
    positions: Mapping[str, int]
    lines: NDArray[np.int64]
    sha256: str
