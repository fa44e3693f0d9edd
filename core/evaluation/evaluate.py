"""Takes as users: virtual trackers in, the bake compared with the motion it came from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import VERSION
from ..database.motion_database import MotionDatabase
from ..database.virtual_root import virtual_root
from ..jobs import Job, part
from ..measure import measures
from ..measure.catalogue import Values, measure, pool, summarise
from ..measure.series import series
from ..measure.subject import Body, body_of
from ..mocap.take import Take
from ..pipeline import BakeResult, bake
from ..recording.body_estimate import BodyEstimate
from ..recording.recording import Recording
from ..recording.simulate import simulate_recording
from ..rig.fit import rig_from_skeleton
from ..settings import BakeSettings

Array = NDArray[np.floating[Any]]
Predict = Callable[[Recording], BodyEstimate]
Show = Callable[[BakeResult], tuple[Array, Array]]
"""World positions `(T, J, 3)` in metres and rotations since T-pose `(T, J, 4)` of the rig's joints, as keyed on an
armature and evaluated by Blender."""

REPORT_FORMAT = "footwork-evaluation"
REPORT_SCHEMA = 4


@dataclass(frozen=True, slots=True, eq=False)
class Evaluated:
    """One take as the user."""

    result: BakeResult
    values: Values
    report: dict[str, Any]


def evaluate_takes(
    takes: Sequence[Take],
    databases: Sequence[MotionDatabase],
    predict: Predict | None,
    settings: BakeSettings,
    show: Show | None = None,
) -> Job[dict[str, Any]]:
    """Bake each take's simulated recording onto the take's own skeleton and measure against the take.

    Args:
        takes: the users, at the databases' rate.
        databases: motion databases; no take of a user should be in them.
        predict: body orientation of a recording; None gives the true one.
        settings: every control of the bake.
        show: measure what Blender shows rather than our own result, and say how far the two are apart.

    Returns:
        JSON-ready report: under `metrics` those over all frames of all takes, and each take's bake report.

    Raises:
        InputError: takes, databases or settings do not go together.
    """
    entries: list[dict[str, Any]] = []
    values: list[Values] = []
    for i, take in enumerate(takes):
        span = i / len(takes), (i + 1) / len(takes)
        done = yield from part(evaluate_take(take, databases, predict, settings, show), *span)
        entries.append(done.report)
        values.append(lighten(done.values))
    metrics = summarise(pool(values))
    timing = {stage: sum(entry["timing_s"][stage] for entry in entries) for stage in entries[0]["timing_s"]}
    return {
        "format": REPORT_FORMAT,
        "schema": REPORT_SCHEMA,
        "producer": f"footwork {VERSION}",
        "measured": "in Blender" if show else "core",
        "metrics": metrics,
        "takes": entries,
        "settings": asdict(settings),
        "true_orientation": predict is None,
        "timing_s": timing,
        "inputs": _inputs(takes, databases),
        "warnings": [*seen_before(takes, databases)],
        "experiments": [],
    }


def evaluate_take(
    take: Take,
    databases: Sequence[MotionDatabase],
    predict: Predict | None,
    settings: BakeSettings,
    show: Show | None = None,
) -> Job[Evaluated]:
    """One take as the user; arguments as for `evaluate_takes`."""
    recording = simulate_recording(take.motion, take.name)
    true = BodyEstimate(virtual_root(take.motion, 0.0)[1])
    rig = rig_from_skeleton(take.motion.skeleton, take.name)
    # the avatar is the user: what is compared with the truth must not be scaled
    settings = replace(settings, scale_to_rig=False)
    result = yield from bake(
        recording, databases, predict or (lambda _: true), rig, settings, truth=take.motion
    )
    body = body_of(result.motion)
    report = {"take": take.file, **result.report}
    if show:
        yield 1.0, "Evaluating in Blender"
        shown = Body(body.skeleton, body.fps, *show(result))
        report["agreement"] = agreement(shown, body)
        body = shown
    values = measure(result.yardstick, body)
    report.update(metrics=summarise(values), series=series(values))
    return Evaluated(result, values, report)


def agreement(a: Body, b: Body) -> dict[str, float]:
    """The most that any joint of two bodies is apart in any frame."""
    return {
        "position_mm": float(1000.0 * measures.distances(a.positions, b.positions).max()),
        "rotation_deg": float(np.degrees(measures.rotation_errors(a.rotations, b.rotations).max())),
    }


def seen_before(takes: Sequence[Take], databases: Sequence[MotionDatabase]) -> list[str]:
    """A line for each take that is in a database: it would be judged by its own motion."""
    return [
        f"{take.name} is in the database {database.name}: its figures flatter"
        for take in takes
        for database in databases
        if take.sha256 and any(clip.sha256 == take.sha256 for clip in database.clips)
    ]


def lighten(values: Values) -> Values:
    """The values in single precision, to be kept."""
    own, floor = (
        {name: array.astype(np.float32) for name, array in side.items()}
        for side in (values.own, values.floor)
    )
    return replace(values, own=own, floor=floor)


def _inputs(takes: Sequence[Take], databases: Sequence[MotionDatabase]) -> list[dict[str, str]]:
    rows = [{"kind": "take", "name": take.file, "sha256": take.sha256} for take in takes]
    rows += [{"kind": "database", "name": d.name, "sha256": d.sha256} for d in databases]
    return rows
