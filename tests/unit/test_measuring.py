"""Cuts of true surfaces one by one, against what is gone of the whole."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from autobalance.balancing.measuring import MAX_SUM_DIFFERENCE_SHARE, _refuse_contradiction
from autobalance.errors import SolidError
from autobalance.rigid_rotor.unbalance import Moments

STEEL = 7.85e-3


@pytest.mark.parametrize(
    ("share", "refused"), [(0.9 * MAX_SUM_DIFFERENCE_SHARE, False), (1.1 * MAX_SUM_DIFFERENCE_SHARE, True)]
)
def test_cuts_that_do_not_add_up_to_what_is_gone_are_refused(share: float, refused: bool) -> None:
    def cut(volume_mm3: float) -> Any:
        return SimpleNamespace(correction=lambda _: SimpleNamespace(removed_volume_mm3=volume_mm3))

    made, own = [(cut(600.0), 1.0), (cut(777.0), 2.0)], [None, SimpleNamespace(removed_volume_mm3=400.0)]
    whole = Moments.point(-STEEL * 1000.0 * (1.0 + share), np.zeros(3))
    if not refused:
        _refuse_contradiction(made, cast(Any, own), whole, STEEL)
        return
    with pytest.raises(SolidError, match=r"the cuts remove 1000 mm³ singly, but 1005\.5 mm³ together: the"):
        _refuse_contradiction(made, cast(Any, own), whole, STEEL)
