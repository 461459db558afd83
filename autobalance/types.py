"""Types of arrays."""

from __future__ import annotations

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
"""Of one type, integer or not."""
