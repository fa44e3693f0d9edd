"""A motion on another skeleton: rotations since T-pose by role, spine resampled, hips scaled by leg length.

Both skeletons are canonical (T-pose at zero rotation, facing +Y), so the world rotation since T-pose of a
joint is the same statement about both bodies, whatever their rest poses and bone rolls were.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from . import forward_kinematics as fk
from .motion import Motion
from .skeleton import Skeleton
from .trunk import neck, pelvis, spine, thighs_middle

Array = NDArray[np.floating[Any]]


def retarget(motion: Motion, target: Skeleton, *, scale_travel: bool = False) -> Motion:
    """`motion` on the skeleton `target`.

    A joint takes the world rotation of the joint with its role. The spine between hips and chest and the neck
    between chest and head are resampled along the chain where the numbers of joints differ; any other joint
    without a counterpart follows its parent. The middle of the thigh joints keeps its height over that of the
    T-pose, scaled by the ratio of leg lengths; its path over the ground is kept, or scaled likewise with
    `scale_travel`.

    Args:
        motion: on any skeleton, metres.
        target: skeleton to move.
        scale_travel: scale the path over the ground about the world's origin by the ratio of leg lengths.

    Returns:
        The motion on `target` at the same rate; `motion` itself where the skeletons are the same.
    """
    source = motion.skeleton
    if same_skeleton(source, target):
        return motion
    turned = fk.global_rotations(motion.rotations, source.parents)
    given = {joint: turned[:, joint] for joint in range(len(source))}
    world = _chain_rotations(source, target, given)
    rotations = np.empty((len(motion), len(target), 4))
    for j, role in enumerate(target.roles):
        above = int(target.parents[j])
        if j not in world:
            known = source.find(role) if role else -1
            world[j] = given[known] if known >= 0 else world[above]
        if not j:
            rotations[:, j] = world[j]
        elif world[j] is world[above]:
            rotations[:, j] = quat.IDENTITY
        else:
            rotations[:, j] = quat.continuous(quat.multiply(quat.conjugate(world[above]), world[j]))
    return Motion(target, motion.fps, _hips_positions(motion, target, given[0], scale_travel), rotations)


def same_skeleton(a: Skeleton, b: Skeleton) -> bool:
    """Whether two skeletons have the same joints, roles and proportions."""
    return a is b or (
        a.names == b.names
        and a.roles == b.roles
        and np.array_equal(a.parents, b.parents)
        and np.array_equal(a.offsets, b.offsets)
    )


def _chain_rotations(source: Skeleton, target: Skeleton, given: dict[int, Array]) -> dict[int, Array]:
    """World rotations `(T, 4)` of the target's joints from hips to head, by joint."""
    hips = dict.fromkeys(pelvis(target), given[0])
    spines = spine(source), spine(target)
    heads = source.joint("head"), target.joint("head")
    upper = [spines[0][-1], *neck(source), heads[0]], [spines[1][-1], *neck(target), heads[1]]
    return _resample(source, target, upper, given) | _resample(source, target, spines, given) | hips


def _resample(
    source: Skeleton, target: Skeleton, chains: tuple[list[int], list[int]], given: dict[int, Array]
) -> dict[int, Array]:
    """World rotations of a target chain whose two ends turn as the source chain's ends do."""
    if len(chains[0]) == len(chains[1]):
        return {t: given[s] for s, t in zip(*chains, strict=True)}
    if len(chains[0]) == 1 or len(chains[1]) == 1:
        return dict.fromkeys(chains[1], given[chains[0][0]])
    knots, places = _arc(source, chains[0]), _arc(target, chains[1])
    before = np.clip(np.searchsorted(knots, places, side="right") - 1, 0, len(knots) - 2)
    shares = (places - knots[before]) / (knots[before + 1] - knots[before])
    return {
        joint: quat.slerp(given[chains[0][k]], given[chains[0][k + 1]], share)
        for joint, k, share in zip(chains[1], before.tolist(), shares, strict=True)
    }


def _arc(skeleton: Skeleton, chain: list[int]) -> Array:
    """Place of each joint of a chain of two or more along it, from 0 at the first to 1 at the last."""
    lengths = np.linalg.norm(skeleton.offsets[chain[1:]], axis=-1)
    along = np.concatenate([[0.0], np.cumsum(np.maximum(lengths, 1e-6))])
    return along / along[-1]


def _hips_positions(motion: Motion, target: Skeleton, hips: Array, scale_travel: bool) -> Array:
    """Hips of the target `(T, 3)`; the thighs' middle rather than the hips joint is what the legs see."""
    source = motion.skeleton
    ratio = target.leg_length() / source.leg_length()
    own, others = thighs_middle(target), thighs_middle(source)
    middle = motion.positions + quat.rotate(hips, others)
    middle[:, 2] -= source.offsets[0, 2] + others[2]
    middle[:, 2] *= ratio
    middle[:, 2] += target.offsets[0, 2] + own[2]
    if scale_travel:
        middle[:, :2] *= ratio
    return middle - quat.rotate(hips, own)
