"""Mannequins: closed, symmetric, on the floor, and carried by the joints that are there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.skeleton import Skeleton
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.mannequin.build import ACCENT, BODY, make_mannequin

from .test_surface import edges, volume

SKELETON = demo_skeleton(1.75)


def without(skeleton: Skeleton, *parts: str) -> Skeleton:
    """The skeleton with joints left out; their children hang on what they hung on."""
    gone = {j for j, role in enumerate(skeleton.roles) if role.partition(".")[0] in parts}
    kept = [j for j in range(len(skeleton)) if j not in gone]
    positions = skeleton.tpose_positions()
    parents: list[int] = []
    for joint in kept:
        above = int(skeleton.parents[joint])
        while above in gone:
            above = int(skeleton.parents[above])
        parents.append(above)
    offsets = np.array(
        [positions[j] - (positions[p] if p >= 0 else 0.0) for j, p in zip(kept, parents, strict=True)]
    )
    return Skeleton(
        tuple(skeleton.names[j] for j in kept),
        np.array([kept.index(p) if p >= 0 else -1 for p in parents], dtype=np.intp),
        offsets,
        tuple(skeleton.roles[j] for j in kept),
        skeleton.tips[kept],
    )


def test_a_closed_body_of_human_volume_stands_on_the_floor() -> None:
    made = make_mannequin(SKELETON)
    found = edges(made.quads)
    assert all(found[b, a] == count for (a, b), count in found.items())
    body = made.quads[made.materials == BODY]
    # 60 to 90 kg at about the density of water; where hands overlap wrists is little
    assert 0.060 < volume(made.vertices, body) < 0.090
    assert made.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-3)
    assert 1.65 < made.vertices[:, 2].max() < 1.85
    assert set(made.materials.tolist()) == {BODY, ACCENT}


def test_left_is_the_mirror_image_of_right() -> None:
    vertices = make_mannequin(SKELETON).vertices
    left, right = vertices[vertices[:, 0] < -0.02], vertices[vertices[:, 0] > 0.02]
    mirrored = right * [-1.0, 1.0, 1.0]
    for part in (left[::97], mirrored[::97]):
        other = mirrored if part is not mirrored and part[0] in left else left
        nearest = np.min(np.linalg.norm(part[:, None] - other[None], axis=-1), axis=1)
        assert nearest.max() < 0.015


def test_every_vertex_is_carried_by_its_own_limb() -> None:
    made = make_mannequin(SKELETON)
    assert made.weights.sum(axis=1) == pytest.approx(np.ones(len(made.vertices)))
    left = [j for j, role in enumerate(SKELETON.roles) if role.endswith(".L")]
    right = [j for j, role in enumerate(SKELETON.roles) if role.endswith(".R")]
    x = made.vertices[:, 0]
    assert made.weights[x > 0.03][:, left].max() == 0.0
    assert made.weights[x < -0.03][:, right].max() == 0.0
    joints = SKELETON.tpose_positions()
    for first, last in (("upper_arm", "forearm"), ("forearm", "hand"), ("thigh", "shin"), ("shin", "foot")):
        for side in "LR":
            a, b = (joints[SKELETON.joint(f"{part}.{side}")] for part in (first, last))
            along = (made.vertices - a) @ (b - a) / ((b - a) @ (b - a))
            away = np.linalg.norm(made.vertices - a - along[:, None] * (b - a), axis=1)
            middle = (np.abs(along - 0.5) < 0.1) & (away < 0.11) & (x * a[0] > 0.0)
            assert middle.sum() > 20
            assert made.weights[middle, SKELETON.joint(f"{first}.{side}")].min() > 0.9
    fingers = x < joints[SKELETON.joint("hand.L"), 0] - 0.05
    assert made.weights[fingers, SKELETON.joint("hand.L")].min() > 0.9
    crown = made.vertices[:, 2] > joints[SKELETON.joint("head"), 2] + 0.06
    assert made.weights[crown, SKELETON.joint("head")].min() > 0.95


@pytest.mark.parametrize("height", [1.2, 1.5, 2.05])
def test_it_is_as_large_as_its_skeleton(height: float) -> None:
    usual, other = make_mannequin(SKELETON), make_mannequin(demo_skeleton(height))
    share = height / 1.75
    assert np.ptp(other.vertices, axis=0) == pytest.approx(share * np.ptp(usual.vertices, axis=0), rel=0.01)
    assert len(other.vertices) == pytest.approx(len(usual.vertices), rel=0.05)


@pytest.mark.parametrize(
    "parts", [("toe",), ("neck",), ("clavicle",), ("spine1", "spine2", "spine3", "chest")]
)
def test_skeletons_that_lack_joints(parts: tuple[str, ...]) -> None:
    skeleton = without(SKELETON, *parts)
    made = make_mannequin(replace(skeleton, tips=np.zeros_like(skeleton.tips)))
    assert made.weights.shape == (len(made.vertices), len(skeleton))
    assert made.weights.sum(axis=1) == pytest.approx(np.ones(len(made.vertices)))
    whole = make_mannequin(SKELETON).vertices
    assert np.ptp(made.vertices, axis=0) == pytest.approx(np.ptp(whole, axis=0), rel=0.03)
