"""A body as rigs have it, for tests of what walks up and down a skeleton."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import Skeleton

# name, parent, role, metres from the parent; the names tell what the joints without a role are
ROWS = (
    ("hips", "", "hips", (0.01, -0.02, 0.97)),
    ("pelvis", "hips", "", (0.0, 0.01, -0.03)),
    ("back", "pelvis", "spine1", (0.01, -0.02, 0.11)),
    ("between", "back", "", (-0.01, 0.01, 0.13)),
    ("breast", "between", "chest", (0.0, 0.02, 0.17)),
    ("nape", "breast", "neck", (0.0, -0.03, 0.19)),
    ("atlas", "nape", "", (0.01, 0.02, 0.07)),
    ("skull", "atlas", "head", (-0.01, 0.01, 0.05)),
    ("thigh l", "pelvis", "thigh.L", (-0.09, 0.01, -0.04)),
    ("twist l", "thigh l", "", (0.01, 0.02, -0.2)),
    ("shin l", "twist l", "shin.L", (0.02, -0.01, -0.22)),
    ("foot l", "shin l", "foot.L", (-0.03, -0.03, -0.4)),
    ("toe l", "foot l", "toe.L", (-0.02, 0.14, -0.06)),
    ("thigh r", "pelvis", "thigh.R", (0.1, 0.0, -0.05)),
    ("shin r", "thigh r", "shin.R", (0.01, 0.03, -0.41)),
    ("foot r", "shin r", "foot.R", (0.02, -0.05, -0.39)),
    ("arm l", "breast", "upper_arm.L", (-0.18, -0.01, 0.14)),
    ("elbow l", "arm l", "forearm.L", (-0.29, 0.02, 0.01)),
    ("hand l", "elbow l", "hand.L", (-0.25, 0.01, -0.02)),
    ("collar r", "breast", "clavicle.R", (0.04, 0.01, 0.12)),
    ("arm r", "collar r", "upper_arm.R", (0.13, -0.02, 0.01)),
    ("elbow r", "arm r", "forearm.R", (0.27, 0.03, 0.0)),
    ("hand r", "elbow r", "hand.R", (0.26, -0.01, 0.02)),
)
TIPS = {"toe l": (0.01, 0.06, -0.01), "foot r": (0.02, 0.13, -0.07)}


def _crooked(shuffled: int | None = None) -> Skeleton:
    rows = list(ROWS)
    if shuffled is not None:
        order = np.random.default_rng(shuffled).permutation(len(rows)).tolist()
        done: list[int] = []
        while order:  # parents before children, otherwise in any order
            ready = next(i for i in order if not rows[i][1] or any(rows[j][0] == rows[i][1] for j in done))
            order.remove(ready)
            done.append(ready)
        rows = [rows[i] for i in done]
    names = [row[0] for row in rows]
    tips = np.array([TIPS.get(name, (0.0, 0.0, 0.0)) for name in names])
    parents = np.array([names.index(row[1]) if row[1] else -1 for row in rows], dtype=np.intp)
    return Skeleton(
        tuple(names), parents, np.array([row[3] for row in rows]), tuple(row[2] for row in rows), tips
    )


@pytest.fixture(scope="session")
def crooked() -> Callable[..., Skeleton]:
    """A body with joints between roles, unequal sides, one toe and one clavicle: `crooked(seed of the joints' order)`.

    Its thighs hang from a joint below the hips, its left thigh has a twist joint, and no bone lies along an axis.
    """
    return _crooked


@pytest.fixture(scope="session")
def moved(tumble) -> Callable[..., Motion]:
    """A motion in which joints turn all the time: `moved(skeleton, frames, seed)`, all but those named pelvis."""

    def make(skeleton: Skeleton, frames: int = 20, seed: int = 0) -> Motion:
        positions = np.random.default_rng(seed).normal(size=(frames, 3))
        rotations = tumble(frames, 60.0, len(skeleton), seed)
        rotations[:, [name == "pelvis" for name in skeleton.names]] = [1.0, 0.0, 0.0, 0.0]
        return Motion(skeleton, 60.0, positions, rotations)

    return make
