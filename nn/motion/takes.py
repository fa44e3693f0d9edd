"""The starter takes: what the motion model makes of scripts, the same on every machine."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...core.body.motion import Motion
from ...core.jobs import Job
from . import ways
from .body import starter_skeleton
from .cleanup import clean
from .conditions import body_of, conditions, soft_contacts
from .decoder import LATENT, MotionModel
from .steps import plan_steps

FPS = 60.0
WEIGHTS = Path(__file__).parents[1] / "weights" / "motion.npz"

Script = Callable[[np.random.RandomState, float], list[ways.Leg]]
SCRIPTS: tuple[tuple[str, str, Script, float], ...] = (
    ("stand", "reactidle", ways.standing, 18.0),
    ("stand_play", "fubot", ways.standing, 16.0),
    ("walk", "o3de", ways.walking, 46.0),
    ("walk_other", "xsens", ways.walking, 16.0),
    ("curves", "o3de", ways.curves, 34.0),
    ("crab", "o3de", ways.crabbing, 34.0),
    ("side_steps", "o3de", ways.side_stepping, 30.0),
    ("back", "o3de", ways.backing, 26.0),
    ("turn", "o3de", ways.turning, 36.0),
    ("jog", "o3de", ways.jogging, 50.0),
    ("jog_other", "xsens", ways.jogging, 16.0),
    ("crouch", "o3de", ways.crouching, 40.0),
    ("roam", "fubot", ways.roaming, 34.0),
    ("roam_other", "o3de", ways.roaming, 20.0),
)
"""Name, person, script and seconds of each take; mirrored they are twice as long."""


def starter_takes(model: MotionModel, fps: float = FPS, seed: int = 0) -> Job[list[tuple[str, Motion]]]:
    """Names and motions of all starter takes, equal on all machines to 0.1 mm.

    Args:
        model: that ships, or another.
        fps: a multiple of 30.
        seed: of the scripts, steps and manners.
    """
    made: list[tuple[str, Motion]] = []
    for n, (name, person, script, seconds) in enumerate(SCRIPTS):
        yield n / len(SCRIPTS), "starter motion: takes"
        rng = np.random.RandomState(1000 * seed + n)
        made.append((name, starter_take(model, person, script(rng, seconds), rng, fps)))
    return made


def starter_take(
    model: MotionModel, person: str, legs: list[ways.Leg], rng: np.random.RandomState, fps: float = FPS
) -> Motion:
    """What a person does on a way."""
    root = ways.way(legs, fps, rng)
    contacts = plan_steps(root, rng, starter_skeleton().offsets[0, 2])
    who = model.people.index(person)
    mean, deviation = (table[who] for table in model.manners)
    noise = np.stack([ways.wander(rng, len(root), fps, 4.0) for _ in range(LATENT)], axis=1)
    told = conditions(root, soft_contacts(contacts, fps))
    poses = model.poses(told, who, mean + deviation * 0.8 * noise)
    return clean(*body_of(poses, root), root, contacts)
