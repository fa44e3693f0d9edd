"""The last step of the method: the matched motion on a rig, its feet, head and hands where they belong."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.legs import legs_of
from ..body.motion import Motion
from ..body.retarget import retarget
from ..body.skeleton import Skeleton
from ..methods import FOOT_PLANS
from ..recording.recording import Recording
from ..recording.targets import joint_targets
from ..settings import BakeSettings
from .arms import reach_hands
from .feet import FootPlan, level_soles, place_feet
from .ground import Footing, Ground, stand
from .head import place_head
from .known import Known
from .lying import flat, lay_feet, lying

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class AvatarResult:
    """The avatar, and what it could not reach."""

    motion: Motion
    """On the rig's skeleton, world metres."""
    contacts: NDArray[np.bool_]
    """`(T, 2)` left, right foot on the ground; of planted feet the frames in which the toe stands still."""
    unreachable: NDArray[np.bool_]
    """`(T, 2)` left, right hand tracked but out of reach."""
    lies: Array
    """`(T,)` how much the body lies, from 0 to 1."""
    footing: Footing | None = None
    """What a scene's ground does to the body; None on a flat floor."""


def animate(
    motion: Motion,
    contacts: NDArray[np.bool_],
    recording: Recording,
    skeleton: Skeleton,
    settings: BakeSettings,
    known: Known | None = None,
    ground: Ground | None = None,
) -> AvatarResult:
    """Bring a matched motion onto a skeleton, its head and hands to the trackers, its feet to the floor.

    Args:
        motion: the matched motion on the database's skeleton, sized for the recording, world metres.
        contacts: `(T, 2)` its foot contacts.
        recording: trackers at the motion's rate, sized for `skeleton`.
        skeleton: the rig's.
        settings: `head`, `arms`, `feet`, `unlock_distance` and `halflife` are used.
        known: what else is known of the body.
        ground: what the feet stand on, in the recording's world; head and hands go up and down with the body.
            None for a flat floor.
    """
    targets, rotations = joint_targets(recording)
    body = retarget(motion, skeleton)
    steps = body
    standing = float(skeleton.tpose_positions()[skeleton.joint("head"), 2])
    head = targets[:, 0], rotations[:, 0], standing, motion.fps
    lies = lying(*head) * recording.valid[:, 0] * settings.head
    trunk = flat(*head)
    if settings.head:
        body, moved = place_head(
            body, targets[:, 0], rotations[:, 0], recording.valid[:, 0], known, (trunk, lies)
        )
        # feet keep the matched motion's height and go along with the body over the ground
        steps = replace(steps, positions=steps.positions + np.pad(moved, ((0, 0), (0, 1))))
    plan: FootPlan = FOOT_PLANS.function(settings.feet)(steps, contacts, settings, body)
    if known is not None and known.soles is not None:
        plan = level_soles(plan, legs_of(skeleton), known.soles)
    del steps  # an hour of it is 160 MB
    if settings.head:
        plan = lay_feet(plan, body, trunk, lies)
    footing = None
    if ground is not None:
        plan, footing = stand(body, plan, plan.contacts, ground)
        up = footing.lift[:, None] * np.array([0.0, 0.0, 1.0])
        targets, body = targets + up[:, None], replace(body, positions=body.positions + up)
    body = place_feet(body, plan)
    unreachable = np.zeros(contacts.shape, np.bool_)
    if settings.arms:
        body, unreachable = reach_hands(
            body, targets[:, 1:], rotations[:, 1:], recording.valid[:, 1:], known and known.elbows
        )
    return AvatarResult(body, plan.contacts, unreachable, lies, footing)
