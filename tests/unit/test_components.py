"""Connected components against scipy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from autobalance.solid.mesh.mesh import components, numbered_components


@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.integers(0, 80), st.sampled_from([2, 3]))
def test_components_are_those_of_scipy(seed: int, count: int, links: int, width: int) -> None:
    rows = np.random.default_rng(seed).integers(0, count, (links, width))
    start, end = rows[:, :-1].reshape(-1), rows[:, 1:].reshape(-1)
    graph = coo_array((np.ones(len(start)), (start, end)), shape=(count, count))
    number, label = connected_components(graph, directed=False)
    here, found = numbered_components(rows, count)
    assert found == number
    assert len(set(zip(here.tolist(), label.tolist(), strict=True))) == number


@pytest.mark.parametrize("shuffled", [False, True])
def test_a_long_chain_is_one_component_named_by_its_lowest_node(shuffled: bool) -> None:
    count = 10_000
    node = np.random.default_rng(0).permutation(count) if shuffled else np.arange(count)
    assert not components(np.stack([node[:-1], node[1:]], axis=1), count).any()
