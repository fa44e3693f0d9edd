"""A motion as the keys of a rig's pose bones: from the canonical skeleton back to an armature.

See `fit` for the rotations D, T and Q.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.edit import resample
from ..body.motion import Motion
from ..maths import quat
from .fit import RigFit
from .mirror import LOCATION, ROTATION
from .rig import BoneTracks

Array = NDArray[np.floating[Any]]


def to_bone_tracks(motion: Motion, fit: RigFit, fps: float) -> BoneTracks:
    """Pose-bone channels of a motion on `fit.skeleton`, at `fps` frames per second.

    Bones with a role are keyed, and bones in between that leave their rest. Bones above the hips count as
    being at rest. Formula: q = (P_parent (R_parent^-1 R))^-1 P with rest R and pose P in armature space; for a
    loose bone, as for the hips, q = R^-1 P.
    """
    motion = resample(motion, fps)
    skeleton, rig = fit.skeleton, fit.rig
    parents = {skeleton.names.index(bone): _parent(fit, above) for bone, above in rig.placed}
    loose = np.array([j in parents or name in rig.loose for j, name in enumerate(skeleton.names)])
    loose[0] = True
    # with a local rotation L, P = P_parent T_parent^-1 L T: before and after L stand constants
    hang = quat.multiply(quat.conjugate(fit.rest[skeleton.parents]), fit.rest)
    follows = quat.multiply(fit.tpose[skeleton.parents], hang)
    before = quat.conjugate(np.where(loose[:, None], quat.multiply(fit.turn, fit.rest), follows))
    turns = motion.rotations
    if loose[1:].any():
        turns = np.where(loose[:, None], motion.forward()[1], turns)
    # products with constants on both sides as one matrix a joint
    products = quat.multiply(quat.multiply(before[:, None], np.eye(4)), fit.tpose[:, None])
    basis = (np.swapaxes(products, -1, -2) @ turns.transpose(1, 2, 0)).transpose(2, 0, 1)
    places = _place(motion, fit, parents, basis)
    moved = np.abs(basis[..., 1:]).max(axis=(0, 2)) > 1e-6
    there = np.array([name not in rig.absent for name in skeleton.names])
    keyed = np.flatnonzero(there & (moved | np.array([role != "" for role in skeleton.roles])))
    heads = rig.rest[fit.bones[0], :3, 3]
    locations = quat.rotate(quat.conjugate(fit.rest[0]), fit.to_armature(motion.positions) - heads)
    turned = _shortest(quat.continuous(basis[:, keyed]))
    return BoneTracks(
        tuple(skeleton.names[j] for j in keyed),
        motion.fps,
        locations * LOCATION if rig.mirrored else locations,
        turned * ROTATION if rig.mirrored else turned,
        tuple(skeleton.names[j] for j in parents),
        places * LOCATION if rig.mirrored else places,
    )


def _parent(fit: RigFit, bone: str) -> int:
    """The joint that moves a bone's children: its own or the nearest above; -1 where it is above the hips."""
    rig, names = fit.rig, fit.skeleton.names
    if not bone:
        return -1
    index = rig.bones.index(bone)
    line = [rig.bones[b] for b in (index, *hierarchy.above(rig.parents, index))]
    return next((names.index(name) for name in line if name in names), -1)


def _place(motion: Motion, fit: RigFit, parents: dict[int, int], basis: Array) -> Array:
    """Locations `(T, P, 3)` of bones that hang elsewhere; their rotations in `basis`, `(T, J, 4)`, are changed too.

    Args:
        motion: what the bones are to show.
        fit: the rig's.
        parents: for each such joint the joint that moves it, -1 for none.
        basis: rotations as of bones without a parent.
    """
    out = np.zeros((len(motion), len(parents), 3))
    if not parents:
        return out
    positions, turned = motion.forward()
    rest = fit.rig.rest[fit.bones]
    for k, (joint, above) in enumerate(parents.items()):
        place = fit.to_armature(positions[:, joint])
        if above >= 0:
            # what the parent has moved by since its rest
            pose = quat.multiply(quat.conjugate(fit.turn), quat.multiply(turned[:, above], fit.tpose[above]))
            back = quat.conjugate(quat.multiply(pose, quat.conjugate(fit.rest[above])))
            place = quat.rotate(back, place - fit.to_armature(positions[:, above])) + rest[above, :3, 3]
            if fit.skeleton.names[joint] not in fit.rig.loose:
                own = quat.multiply(fit.rest[joint], basis[:, joint])
                basis[:, joint] = quat.multiply(quat.conjugate(fit.rest[joint]), quat.multiply(back, own))
        out[:, k] = quat.rotate(quat.conjugate(fit.rest[joint]), place - rest[joint, :3, 3])
    return out


def _shortest(rotations: Array) -> Array:
    """Continuous quaternions `(T, K, 4)` with the sign that lies nearer to rest at the first frame."""
    return np.where(rotations[:1, :, :1] < 0.0, -rotations, rotations)
