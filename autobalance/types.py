"""Types of arrays, and of tables by key."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]
Floats = NDArray[Any]
"""float32 or float64."""
Numbers = NDArray[Any]
"""Array of one type, integer or not."""
Values = Mapping[str, Any]
"""A table of a file or an object of JSON, as it is read."""
