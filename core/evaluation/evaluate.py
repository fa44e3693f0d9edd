"""Takes as users: virtual trackers in, the bake compared with the motion it came from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import MotionDatabase
from ..database.virtual_root import virtual_root
from ..jobs import Job, part
from ..mocap.skeleton import Take
from ..pipeline import bake
from ..recording.recording import Recording
from ..recording.simulate import simulate_recording
from ..rig.fit import rig_from_skeleton
from ..settings import BakeSettings

Array = NDArray[np.floating[Any]]
REPORT_FORMAT = "footwork-evaluation"
REPORT_SCHEMA = 1


def evaluate_takes(
    takes: Sequence[Take],
    databases: Sequence[MotionDatabase],
    predict: Callable[[Recording], Array] | None,
    settings: BakeSettings,
) -> Job[dict[str, Any]]:
    """Bake each take's simulated recording onto the take's own skeleton and measure against the take.

    Args:
        takes: the users, at the databases' rate.
        databases: motion databases; no take of a user should be in them.
        predict: body yaws of a recording; None gives the true ones.
        settings: every control of the bake.

    Returns:
        JSON-ready report: one bake report for each take, and the mean over takes of each metric's mean.
    """
    entries: list[dict[str, Any]] = []
    for i, take in enumerate(takes):
        span = i / len(takes), (i + 1) / len(takes)
        entries.append((yield from part(_evaluate(take, databases, predict, settings), *span)))
    names = [name for name, value in entries[0]["metrics"].items() if isinstance(value, dict)]
    means = {name: float(np.mean([entry["metrics"][name]["mean"] for entry in entries])) for name in names}
    return {"format": REPORT_FORMAT, "schema": REPORT_SCHEMA, "metrics": means, "takes": entries}


def _evaluate(
    take: Take,
    databases: Sequence[MotionDatabase],
    predict: Callable[[Recording], Array] | None,
    settings: BakeSettings,
) -> Job[dict[str, Any]]:
    recording = simulate_recording(take.motion, take.name)
    true_yaws = virtual_root(take.motion, 0.0)[1]
    rig = rig_from_skeleton(take.motion.skeleton, take.name)
    # the avatar is the user: what is compared with the truth must not be scaled
    settings = replace(settings, scale_to_rig=False)
    result = yield from bake(
        recording, databases, predict or (lambda _: true_yaws), rig, settings, truth=take.motion
    )
    return {"take": take.file, **result.report}
