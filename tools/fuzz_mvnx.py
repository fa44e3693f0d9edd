"""MVNX files as Xsens' program writes them, made of a motion."""

from __future__ import annotations

import numpy as np
from footwork.core.body.motion import Motion
from footwork.core.maths import quat

SEGMENTS = {
    "hips": "Pelvis", "spine1": "L5", "spine2": "L3", "spine3": "T12", "chest": "T8", "neck": "Neck", "head": "Head",
    "clavicle": "Shoulder", "upper_arm": "UpperArm", "forearm": "ForeArm", "hand": "Hand", "thigh": "UpperLeg",
    "shin": "LowerLeg", "foot": "Foot", "toe": "Toe",
}  # fmt: skip
TO_MVN = quat.from_yaw(-0.5 * np.pi)
"""From +Y ahead to +X ahead."""


def segment_name(role: str) -> str:
    """What MVNX calls the segment that begins at a joint."""
    part, _, side = role.partition(".")
    return {"L": "Left", "R": "Right", "": ""}[side] + SEGMENTS[part]


def format_mvnx(
    motion: Motion, *, joints: bool = True, tpose: bool = True, head: str = '<?xml version="1.0"?>'
) -> str:
    """A motion in which every joint has a role, and whose joint 0 is the hips."""
    skeleton = motion.skeleton
    names = [segment_name(role) for role in skeleton.roles]
    positions, rotations = motion.forward()
    positions = quat.rotate(TO_MVN, positions)
    rotations = quat.multiply(quat.multiply(TO_MVN, rotations), quat.conjugate(TO_MVN))
    still = quat.rotate(TO_MVN, skeleton.tpose_positions())
    lines = [head, '<mvnx version="4" xmlns="http://www.xsens.com/mvn/mvnx">', "<comment>a &lt; b</comment>"]
    lines.append(f'<subject label="Anna" frameRate="{motion.fps:g}" segmentCount="{len(names)}"><segments>')
    lines += [f'<segment label="{name}" id="{number}"/>' for number, name in enumerate(names, start=1)]
    lines.append("</segments>")
    if joints:
        lines.append("<joints>")
        for joint, parent in enumerate(skeleton.parents.tolist()):
            if parent >= 0:
                lines.append(
                    f"<joint><connector1>{names[parent]}/j{joint}</connector1>"
                    f"<connector2>{names[joint]}/j{joint}</connector2></joint>"
                )
        lines.append("</joints>")
    lines.append("<frames>")
    none = np.tile(quat.IDENTITY, (len(names), 1))
    if tpose:
        lines += [_frame("tpose", still, none), _frame("tpose-isb", still, none)]
    lines += [_frame("normal", place, turn) for place, turn in zip(positions, rotations, strict=True)]
    return "\n".join([*lines, "</frames></subject></mvnx>", ""])


def _frame(kind: str, places: np.ndarray, turns: np.ndarray) -> str:
    orientation, position = (" ".join(f"{v:.8f}" for v in part.ravel()) for part in (turns, places))
    return (
        f'<frame time="0" type="{kind}"><orientation>{orientation}</orientation><position>{position}</position>'
        "<velocity>0 0 0</velocity></frame>"
    )
