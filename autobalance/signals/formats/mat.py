"""MATLAB, version 5 and before: each 1-D numeric array longer than 1 is a channel."""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np

from autobalance.errors import FormatError
from autobalance.signals.formats import agreed_rate
from autobalance.signals.record import Channel, SignalRecord, named

RATE_NAMES = ("fs", "sample_rate")


def read(path: Path, sample_rate_hz: float | None) -> SignalRecord:
    """Read a file; the rate is ``fs`` or ``sample_rate`` [Hz]."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        variables = loadmat(path)
    except NotImplementedError:
        raise FormatError(f"{path.name} is a MATLAB file of version 7.3; save it with -v7") from None
    except (MatReadError, ValueError, TypeError, KeyError, IndexError, EOFError, zlib.error) as error:
        raise FormatError(f"{path.name} is not a MATLAB file of version 5: {error}") from None
    rates = [
        float(variables[key].item()) for key in RATE_NAMES if key in variables and _is_number(variables[key])
    ]
    rate_hz = agreed_rate(path.name, rates[0] if rates else None, sample_rate_hz)
    arrays = {key: np.ravel(value) for key, value in variables.items() if _is_channel(key, value)}
    channels = tuple(Channel(*named(key), rate_hz, value, header=key) for key, value in arrays.items())
    return SignalRecord(path.name, "MAT", channels)


def _is_number(value: object) -> bool:
    return isinstance(value, np.ndarray) and value.size == 1 and value.dtype.kind in "iuf"


def _is_channel(key: str, value: object) -> bool:
    if key.startswith("__") or not isinstance(value, np.ndarray) or value.dtype.kind not in "iufb":
        return False
    return value.size > 1 and value.size == max(value.shape)
