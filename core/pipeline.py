"""The one way through: recording, databases, predictor, rig and settings become bone tracks and a report."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .body.motion import Motion
from .body.skeleton import Skeleton
from .database.motion_database import MotionDatabase
from .errors import InputError
from .jobs import Job, part
from .matching.body_target import body_posture, elbows_of, with_estimate
from .matching.evidence import feet_evidence, surer_contacts
from .matching.inertialization import assemble
from .matching.playback import Playback, match, soles_of
from .matching.posture_model import Posture
from .matching.trajectory import make_trajectory
from .measure.catalogue import Values, measure, summarise
from .measure.series import series
from .measure.subject import Yardstick, body_of
from .recording.body_estimate import BodyEstimate, estimate_doubts
from .recording.recording import Recording
from .recording.resample import resample
from .recording.targets import joint_targets, raised, scale
from .rig.avatar import animate
from .rig.fit import fit_rig, rig_from_skeleton
from .rig.gate import check_finite, check_rig, check_tracks
from .rig.ground import Footing, Ground
from .rig.keys import to_bone_tracks
from .rig.known import Known
from .rig.place import Place, from_start, ground_from, put
from .rig.rig import BoneTracks, Rig
from .settings import BakeSettings, check

Array = NDArray[np.floating[Any]]

REPORT_FORMAT = "footwork-bake-report"
REPORT_SCHEMA = 4
HEAD_HEIGHT = 1.54
"""Height in metres of the head joint of a body of 1.7 m at ease, for which lengths in settings and in code hold."""
SMALLEST, LARGEST = 0.3, 3.0
"""Heights in metres of the bodies that rigs are made as."""


@dataclass(frozen=True, slots=True, eq=False)
class BakeResult:
    """What a bake gives: keys for the rig, and how good they are."""

    rig: Rig
    tracks: BoneTracks
    motion: Motion
    """The avatar on the rig's own skeleton in the world, metres, at the databases' rate."""
    contacts: NDArray[np.bool_]
    """`(T, 2)` left, right foot held on the ground."""
    playback: Playback
    transition_times: Array
    """`(K,)` seconds at which the motion changes its place in the databases."""
    report: dict[str, Any]
    """JSON-ready: metrics, timing, settings, inputs, warnings (DESIGN, "Interfaces")."""
    warnings: tuple[str, ...]
    yardstick: Yardstick
    """What the motion was measured by, for measuring it once more as Blender shows it."""
    place: Place | None = None
    """Where the motion was put, which what it was measured by was not."""
    lost: Array | None = None
    """`(T, 3)` the way over the ground that was taken out of the motion afterwards."""


def bake(
    recording: Recording,
    databases: Sequence[MotionDatabase],
    predict: Callable[[Recording], BodyEstimate],
    rig: Rig | None,
    settings: BakeSettings,
    *,
    output_fps: float | None = None,
    truth: Motion | None = None,
    ground: Ground | None = None,
    place: Place | None = None,
) -> Job[BakeResult]:
    """Animate a rig from a recording.

    Args:
        recording: the three trackers, at any rate.
        databases: one or more motion databases; the first gives the skeleton and the rate.
        predict: the body estimate of a recording at the databases' rate.
        rig: the rig to animate; None makes one as tall as the user from the first database's skeleton.
        settings: every control.
        output_fps: rate of the bone tracks; the databases' rate by default.
        truth: the user's true motion at the databases' rate, in the world of the recording: adds the errors that
            need it and the floors of the others.
        ground: what the avatar stands on, in metres of the world; None for the recording's flat floor.
        place: where the recording is to start; None for the recording's own world.

    Raises:
        InputError: settings out of bounds, no database, databases or rig that do not fit.
    """
    check(settings)
    if not databases:
        raise InputError("no motion database given: build one from takes first")
    clock, fps = _Clock(), databases[0].fps
    rig = rig or _own_rig(recording, databases)
    check_rig(rig)
    fit = fit_rig(rig)
    recording = resample(recording, fps)
    if place is not None:
        recording = from_start(recording)
        ground = None if ground is None else ground_from(ground, place)

    yield 0.02, "Predicting body orientation"
    estimate = predict(recording)
    check_finite(estimate.yaws, "the predictor of the body's direction")
    clock.lap("orientation")

    scales = _scales(recording, databases, fit.skeleton, settings)
    # the search works on the database's own body size; alpha bounds metres of the rig, however large it is
    alpha = settings.alpha * min(scales.size, 1.0)
    sized = replace(settings, alpha=alpha * scales.database / scales.rig)
    playback, posture = yield from part(
        _match(recording, estimate, databases, sized, scales.database), 0.05, 0.6
    )
    clock.lap("search")

    yield 0.6, "Blending poses"
    motion, played = assemble(playback, databases, sized)
    contacts = surer_contacts(played, estimate, settings.step_weight)
    names = ", ".join(base.name for base in databases)
    check_finite(motion.positions, f"a motion database ({names})")
    check_finite(motion.rotations, f"a motion database ({names})")
    clock.lap("blending")

    yield 0.75, "Fitting the rig"
    # at the size for which all lengths, steps and speeds hold, and then as large as the rig
    to_usual = scales.rig / scales.size
    matched = scale_motion(motion, to_usual / scales.database)
    # the head's own place is no place for hips: with the paper's target they stay where the motion has them
    known = Known(soles=soles_of(playback, databases))
    if posture is not None:
        roots = playback.target_positions * (to_usual / scales.database)
        known = replace(known, roots=roots, chest=posture.chest, elbows=elbows_of(estimate))
    usual = scale_skeleton(fit.skeleton, 1.0 / scales.size)
    around = None if ground is None else scale_ground(ground, 1.0 / scales.size)
    avatar = animate(matched, contacts, scale(recording, to_usual), usual, settings, known, around)
    del motion, matched  # an hour of them is 160 MB
    places = avatar.motion.positions * scales.size
    made = replace(avatar.motion, skeleton=fit.skeleton, positions=places)
    trackers = scale(recording, scales.rig)
    clock.lap("rig")

    yield 0.9, "Making keys"
    put_there = made if place is None else put(made, place)
    tracks = to_bone_tracks(put_there, fit, output_fps or fps)
    check_tracks(tracks, rig)
    clock.lap("keys")

    yield 0.95, "Measuring"
    doubts = (
        *_size_doubts(rig, fit.skeleton),
        *recording.doubts,
        *estimate_doubts(estimate, fps),
        *_ground_doubts(avatar.footing, fps),
        *_lying_doubts(avatar.lies, fps),
    )
    yardstick = Yardstick(
        played,
        trackers if avatar.footing is None else raised(trackers, avatar.footing.lift * scales.size),
        playback,
        databases,
        avatar.unreachable,
        scale=scales.rig / scales.database,
        truth=None if truth is None else scale_motion(truth, scales.rig),
        ground=ground,
        doubt=estimate.doubt,
    )
    values = measure(yardstick, body_of(made))
    clock.lap("measures")
    report = _report(recording, databases, settings, scales, values, doubts, clock)
    times = playback.transitions / fps
    return BakeResult(
        rig, tracks, put_there, avatar.contacts, playback, times, report, doubts, yardstick, place
    )


def _size_doubts(rig: Rig, skeleton: Skeleton) -> tuple[str, ...]:
    """A line for a rig that is no body in metres: it moves like any other, but its place and way are as far off."""
    joints = skeleton.tpose_positions()
    height = float((joints + skeleton.tips)[:, 2].max() - joints[:, 2].min())
    if SMALLEST <= height <= LARGEST:
        return ()
    size = f"{rig.name} is {height:.3g} m tall, and bodies are {SMALLEST:g} to {LARGEST:g} m"
    return (f"{size}: check its scale and the scene's unit scale",)


def _ground_doubts(footing: Footing | None, fps: float) -> tuple[str, ...]:
    """What a person should know of the ground, a line each."""
    if footing is None or not footing.bare.any():
        return ()
    seconds = float(footing.bare.sum()) / fps
    return (f"no ground under the feet for {seconds:.1f} s: there it counts as a floor at height 0",)


def _match(
    recording: Recording,
    estimate: BodyEstimate,
    databases: Sequence[MotionDatabase],
    settings: BakeSettings,
    to_database: float,
) -> Job[tuple[Playback, Posture | None]]:
    """The frames to play for a recording scaled to the databases' body, and how that body holds itself."""
    sized = scale(recording, to_database)
    positions, rotations = joint_targets(sized)
    head_height = sized.eye_height - float(sized.mounts.offsets[0, 2])
    targets = positions[:, 0, :2]
    posture = None
    if settings.target == "body":
        posture = body_posture(positions, rotations, sized.valid, head_height, sized.fps, databases)
        posture = with_estimate(posture, estimate, head_height)
        targets = targets + posture.hips
    trajectory = make_trajectory(targets, estimate.yaws, databases[0].fps, settings)
    trajectory = replace(trajectory, feet=feet_evidence(estimate, head_height, settings.step_weight))
    heights = recording.positions[:, 0, 2] / recording.eye_height
    return (yield from match(trajectory, heights, databases, settings)), posture


def _lying_doubts(lies: Array, fps: float) -> tuple[str, ...]:
    """One line where the user lies for half a second or longer, else none."""
    edges = np.flatnonzero(np.diff(lies > 0.5, prepend=False, append=False)).reshape(-1, 2) / fps
    spans = [f"{first:.1f} to {last:.1f} s" for first, last in edges.tolist() if last - first >= 0.5]
    if not spans:
        return ()
    more = f" and {len(spans) - 3} more times" if len(spans) > 3 else ""
    return (
        f"lying from {', '.join(spans[:3])}{more}: people on their feet do not show how; trunk and legs are laid flat "
        "behind the head there, look at them",
    )


def _report(
    recording: Recording,
    databases: Sequence[MotionDatabase],
    settings: BakeSettings,
    scales: _Scales,
    values: Values,
    doubts: Sequence[str],
    clock: _Clock,
) -> dict[str, Any]:
    """What a bake tells of itself."""
    inputs = [{"kind": "recording", "name": recording.file, "sha256": recording.sha256}]
    inputs += [{"kind": "database", "name": base.name, "sha256": base.sha256} for base in databases]
    return {
        "format": REPORT_FORMAT,
        "schema": REPORT_SCHEMA,
        "metrics": summarise(values),
        "series": series(values),
        "timing_s": {**clock.laps, "recorded": float(recording.times[-1])},
        "settings": asdict(settings),
        "inputs": inputs,
        "scale": {"user_to_rig": scales.rig, "user_to_database": scales.database},
        "warnings": list(doubts),
    }


def scale_motion(motion: Motion, factor: float) -> Motion:
    """A motion of a body `factor` times as large, about the floor point under the world's origin."""
    return replace(
        motion, skeleton=scale_skeleton(motion.skeleton, factor), positions=motion.positions * factor
    )


def scale_skeleton(skeleton: Skeleton, factor: float) -> Skeleton:
    """A skeleton `factor` times as large."""
    return replace(skeleton, offsets=skeleton.offsets * factor, tips=skeleton.tips * factor)


def scale_ground(ground: Ground, factor: float) -> Ground:
    """A ground `factor` times as large, about the world's origin."""

    def scaled(points: Array) -> tuple[Array, Array]:
        heights, normals = ground(points / factor)
        return heights * factor, normals

    return scaled


@dataclass(frozen=True, slots=True)
class _Scales:
    """How many times as large as the user the bodies of rig and databases are."""

    rig: float
    database: float
    size: float
    """How many times as large as a body of 1.7 m the rig is; 1 where the recording is not to be scaled."""


def _scales(
    recording: Recording, databases: Sequence[MotionDatabase], rig: Skeleton, settings: BakeSettings
) -> _Scales:
    """By the heights of the head joint at ease; by T-pose heights the avatar would stand on its toes."""
    ease = max(database.head_height / _head_height(database.skeleton) for database in databases)
    user = recording.eye_height - float(recording.mounts.offsets[0, 2])
    at_ease = ease * _head_height(rig)
    to_database = ease * _head_height(databases[0].skeleton) / user
    if not settings.scale_to_rig:
        return _Scales(1.0, to_database, 1.0)
    return _Scales(at_ease / user, to_database, at_ease / HEAD_HEIGHT)


def _own_rig(recording: Recording, databases: Sequence[MotionDatabase]) -> Rig:
    """The first database's body, as tall as the user."""
    skeleton = databases[0].skeleton
    factor = 1.0 / _scales(recording, databases, skeleton, BakeSettings()).rig
    return rig_from_skeleton(scale_skeleton(skeleton, factor), databases[0].name)


def _head_height(skeleton: Skeleton) -> float:
    """Of the head joint in T-pose, metres."""
    return float(skeleton.tpose_positions()[skeleton.joint("head"), 2])


class _Clock:
    """Seconds spent on each stage."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.laps[stage] = now - self._last
        self._last = now
