"""Ways up and down trees of any shape, against the powers of their matrix of parents."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from footwork.core.body import hierarchy
from hypothesis import given
from hypothesis import strategies as st


@st.composite
def trees(draw: st.DrawFn) -> list[int]:
    """Parents before children; several roots are allowed, as bones of a rig may have."""
    count = draw(st.integers(1, 14))
    return [draw(st.integers(-1, joint - 1)) for joint in range(count)]


def over(parents: list[int]) -> np.ndarray:
    """`(J, J)` whether the second joint is above the first, and by how many steps (0 for not)."""
    count = len(parents)
    step = np.zeros((count, count), dtype=int)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            step[joint, parent] = 1
    out, power = np.zeros_like(step), np.eye(count, dtype=int)
    for distance in range(1, count + 1):
        power = power @ step
        out += distance * power
    return out


@given(trees(), st.data())
def test_what_is_above_and_below(parents: list[int], data: st.DataObject) -> None:
    steps = over(parents)
    some = data.draw(st.sets(st.integers(0, len(parents) - 1)))
    for given_as in (parents, np.array(parents, dtype=np.intp)):
        for joint in range(len(parents)):
            found = hierarchy.above(given_as, joint)
            assert set(found) == set(np.flatnonzero(steps[joint]).tolist())
            assert [steps[joint, other] for other in found] == list(range(1, len(found) + 1))
            distances = [(steps[joint, other], other) for other in some if steps[joint, other]]
            assert hierarchy.nearest_above(given_as, joint, some) == (min(distances)[1] if distances else -1)
        ancestors = {other for joint in some for other in np.flatnonzero(steps[joint]).tolist()}
        assert hierarchy.with_ancestors(given_as, some) == sorted(some | ancestors)
        under = {joint for joint in range(len(parents)) if any(steps[joint, other] for other in some)}
        assert hierarchy.below(given_as, some) == sorted(some | under)


@given(trees())
def test_a_path_runs_down_from_its_first_joint_to_its_last(parents: list[int]) -> None:
    steps = over(parents)
    for first, last in np.ndindex(*steps.shape):
        if first == last or steps[last, first]:
            found = hierarchy.path(parents, first, last)
            assert found[0] == first and found[-1] == last and len(found) == steps[last, first] + 1
            assert all(parents[lower] == upper for upper, lower in pairwise(found))
        else:
            with pytest.raises(ValueError):
                hierarchy.path(parents, first, last)


@given(trees(), st.data())
def test_a_part_keeps_the_parents_that_are_in_it(parents: list[int], data: st.DataObject) -> None:
    joints = data.draw(st.permutations(range(len(parents))))[: data.draw(st.integers(0, len(parents)))]
    found = hierarchy.part(parents, joints)
    assert found.dtype == np.intp and found.shape == (len(joints),)
    for k, joint in enumerate(joints):
        assert (joints[found[k]] if found[k] >= 0 else None) == (
            parents[joint] if parents[joint] in joints else None
        )
