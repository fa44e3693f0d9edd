"""Recordings from three animated objects of a scene, and recordings shown as three animated empties."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.errors import InputError
from ..core.maths import quat
from ..core.recording.mounts import DEVICE_MOUNTS
from ..core.recording.raw import RawRecording, Track
from ..core.recording.read import to_recording
from ..core.recording.reading.answers import NO_ANSWERS, Answers
from ..core.recording.recording import TRACKERS, Mounts, Recording
from ..core.recording.resample import resample
from .action import key_transform, scene_fps
from .lookup import metres_per_unit

Array = NDArray[np.floating[Any]]

MOUNT = "footwork_mount"
"""Custom property of a tracker empty: offset (3) and turn (4) of its mount."""
EYE_HEIGHT = "footwork_eye_height"
"""Custom property of the headset's empty, metres."""

AXES = {"Y_FORWARD": quat.IDENTITY, "CAMERA": quat.from_axis("X", -0.5 * np.pi)}
"""Device axes in an object's own: the object points along +Y with Z up, or along -Z with Y up."""


def sample_objects(
    scene: bpy.types.Scene, objects: Sequence[bpy.types.Object], first: int, last: int
) -> tuple[Array, Array]:
    """World positions `(T, N, 3)` in scene units and rotations `(T, N, 4)` of objects at frames `first` to `last`.

    Constraints, parents and drivers count. The scene's current frame is the same afterwards.
    """
    positions = np.empty((last - first + 1, len(objects), 3))
    rotations = np.empty((last - first + 1, len(objects), 4))
    current, subframe = scene.frame_current, scene.frame_subframe
    try:
        for index, frame in enumerate(range(first, last + 1)):
            scene.frame_set(frame)
            for column, obj in enumerate(objects):
                place, turn, _ = obj.matrix_world.decompose()
                positions[index, column], rotations[index, column] = place[:], turn[:]
    finally:
        scene.frame_set(current, subframe=subframe)
    return positions, quat.continuous(rotations)


def recording_from_objects(
    scene: bpy.types.Scene,
    trackers: Sequence[bpy.types.Object | None],
    *,
    axes: str = "Y_FORWARD",
    answers: Answers = NO_ANSWERS,
) -> Recording:
    """The recording that headset, left and right controller objects give over the scene's frame range.

    Empties that `show_recording` made carry mounts and eye height with them; other objects count as real devices.

    Args:
        scene: gives frame range, rate and unit.
        trackers: headset, left, right; a controller that is None counts as lost.
        axes: "Y_FORWARD" or "CAMERA", see `AXES`.
        answers: what a person says of them; by default the eye height is the empties' own, or else the standing
            height found in the motion.

    Raises:
        InputError: there is no headset, an object is given twice, or the range is too short.
    """
    head = trackers[0]
    if head is None:
        raise InputError("Recording: pick the object that moves with the headset")
    present = [obj for obj in trackers if obj is not None]
    if len(set(present)) < len(present):
        raise InputError("Recording: one object is picked twice; pick a different one for each tracker")
    positions, rotations = sample_objects(scene, present, scene.frame_start, scene.frame_end)
    positions = positions * metres_per_unit(scene)
    rotations = quat.multiply(rotations, AXES[axes])
    times = np.arange(len(positions)) / scene_fps(scene)
    valid = np.ones(len(times), dtype=np.bool_)
    tracks: list[Track] = []
    for obj in trackers:
        if obj is None:
            tracks.append(Track(times[:0], np.empty((0, 3)), np.empty((0, 4)), valid[:0]))
        else:
            column = present.index(obj)
            tracks.append(Track(times, positions[:, column], rotations[:, column], valid))
    raw = RawRecording(
        tracks=(tracks[0], tracks[1], tracks[2]),
        found={"format": "scene objects", "objects": ", ".join(obj.name for obj in present)},
        name=head.name,
        mounts=_mounts(trackers),
        eye_height=head.get(EYE_HEIGHT),
        # objects that stand exactly still are meant to
        states_validity=True,
    )
    digest = hashlib.sha256(positions.tobytes() + rotations.tobytes()).hexdigest()
    return to_recording(raw, f"objects of scene {scene.name}", digest, answers)


def show_recording(
    recording: Recording, scene: bpy.types.Scene, frame_start: float = 1.0
) -> list[bpy.types.Object]:
    """Show a recording as three animated empties, Y forward and Z up, in a new collection of the scene.

    Where a tracker was lost its empty stays where the reader's repair puts it.
    """
    fps, unit = scene_fps(scene), metres_per_unit(scene)
    recording = resample(recording, fps)
    collection = bpy.data.collections.new(recording.name)
    scene.collection.children.link(collection)
    empties: list[bpy.types.Object] = []
    for index, tracker in enumerate(TRACKERS):
        empty = bpy.data.objects.new(f"{recording.name} {tracker}", None)
        empty.empty_display_type, empty.empty_display_size = "ARROWS", 0.15 / unit
        empty.rotation_mode = "QUATERNION"
        collection.objects.link(empty)
        positions, rotations = recording.positions[:, index] / unit, recording.rotations[:, index]
        key_transform(empty, positions, rotations, empty.name, fps, frame_start)
        mount = np.concatenate([recording.mounts.offsets[index], recording.mounts.turns[index]])
        empty[MOUNT] = [float(value) for value in mount]
        empties.append(empty)
    empties[0][EYE_HEIGHT] = recording.eye_height
    return empties


def _mounts(trackers: Sequence[bpy.types.Object | None]) -> Mounts:
    offsets, turns = np.array(DEVICE_MOUNTS.offsets), np.array(DEVICE_MOUNTS.turns)
    for index, obj in enumerate(trackers):
        stored = obj.get(MOUNT) if obj is not None else None
        if stored is not None and len(stored) == 7:
            offsets[index], turns[index] = stored[:3], stored[3:]
    return Mounts(offsets=offsets, turns=turns)
