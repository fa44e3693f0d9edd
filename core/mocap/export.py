"""Motions written as BVH in the axes of Xsens files: Y up, centimetres, T-pose at zero facing +Z."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.skeleton import Skeleton
from ..maths import quat
from .bvh import BvhFile

Array = NDArray[np.floating[Any]]

_TO_Y_UP = quat.from_axis("X", -np.pi / 2)
"""From Blender's world to a world with Y up, as Blender's own BVH exporter turns it."""
_FACING_Z = quat.multiply(_TO_Y_UP, quat.from_yaw(np.pi))
"""The same for a body in T-pose, which then faces +Z."""
_ORDER = "YXZ"
_TURNS = tuple(f"{axis}rotation" for axis in _ORDER)
_CENTIMETRES = 100.0


def to_bvh(motion: Motion, name: str) -> BvhFile:
    """The motion as a BVH file, readable by Blender's importer (as it is set) and by `load_take`.

    Joints come in the order of the hierarchy, which may differ from the motion's.

    Args:
        motion: what to write.
        name: file name for the result.
    """
    motion = _depth_first(motion)
    skeleton = motion.skeleton
    turns = quat.multiply(quat.multiply(_FACING_Z, motion.rotations), quat.conjugate(_FACING_Z))
    # the hips' rotation is global: it starts from T-pose axes, but ends in the world's
    turns[:, 0] = quat.multiply(quat.multiply(_TO_Y_UP, motion.rotations[:, 0]), quat.conjugate(_FACING_Z))
    angles = np.degrees(quat.to_euler(turns, _ORDER))
    hips = quat.rotate(_TO_Y_UP, motion.positions) * _CENTIMETRES
    offsets = quat.rotate(_FACING_Z, skeleton.offsets) * _CENTIMETRES
    offsets[0] = 0.0
    leaves = np.setdiff1d(np.arange(len(skeleton)), skeleton.parents)
    return BvhFile(
        names=skeleton.names,
        parents=skeleton.parents,
        offsets=offsets,
        channels=(("Xposition", "Yposition", "Zposition", *_TURNS), *(_TURNS,) * (len(skeleton) - 1)),
        end_sites=quat.rotate(_FACING_Z, skeleton.tips[leaves]) * _CENTIMETRES,
        end_parents=leaves,
        frame_time=1.0 / motion.fps,
        values=np.concatenate([hips, angles.reshape(len(motion), -1)], axis=1),
        file=name,
        sha256="",
    )


def _depth_first(motion: Motion) -> Motion:
    """The motion with its joints in the order in which a file lists them."""
    skeleton = motion.skeleton
    order: list[int] = []
    todo = [0]
    while todo:
        joint = todo.pop()
        order.append(joint)
        todo += np.flatnonzero(skeleton.parents == joint)[::-1].tolist()
    place = np.argsort(order)
    return replace(
        motion,
        rotations=motion.rotations[:, order],
        skeleton=Skeleton(
            names=tuple(skeleton.names[joint] for joint in order),
            parents=np.append(-1, place[skeleton.parents[order[1:]]]),
            offsets=skeleton.offsets[order],
            roles=tuple(skeleton.roles[joint] for joint in order),
            tips=skeleton.tips[order],
        ),
    )
