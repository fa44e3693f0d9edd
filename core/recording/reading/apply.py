"""A file's numbers in Blender's axes and metres, as a reading says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...maths import quat
from ..raw import DIRECTIONS, RawRecording, Reading, Track, change_axes
from .rotations import to_quaternions


def applied(raw: RawRecording, reading: Reading) -> RawRecording:
    """The recording in Blender's axes and metres, as a reading says."""
    turns = [to_quaternions(track.rotations, reading.rotation) for track in raw.tracks]
    tracks = [replace(track, rotations=turn) for track, turn in zip(raw.tracks, turns, strict=True)]
    if reading.hands != "world":
        tracks = [tracks[0], *(_placed(tracks[0], track, reading.hands) for track in tracks[1:])]
    if reading.swapped:
        tracks[1], tracks[2] = tracks[2], tracks[1]
    head, left, right = (_turned(track, reading) for track in tracks)
    extra = tuple(
        replace(
            item,
            rotation="",
            track=_turned(
                replace(
                    item.track,
                    rotations=to_quaternions(item.track.rotations, item.rotation or reading.rotation),
                ),
                reading,
            ),
        )
        for item in raw.extra
    )
    return replace(raw, tracks=(head, left, right), reading=Reading(), extra=extra)


def _placed(head: Track, hand: Track, how: str) -> Track:
    """A hand that was told from the head, in the world."""
    if len(head.times) == 0 or len(hand.times) == 0:
        return hand
    at = np.clip(np.searchsorted(head.times, hand.times), 0, len(head.times) - 1)
    unit = quat.normalize(np.nan_to_num(head.rotations[at]))
    if how == "offset":
        return replace(hand, positions=head.positions[at] + hand.positions)
    return replace(
        hand,
        positions=head.positions[at] + quat.rotate(unit, hand.positions),
        rotations=quat.multiply(unit, hand.rotations),
    )


def _turned(track: Track, reading: Reading) -> Track:
    positions, rotations = change_axes(track.positions * reading.metres, track.rotations, reading.axes)
    if reading.devices and reading.devices != reading.axes:
        world, device = (
            np.array([DIRECTIONS[a] for a in axes]).T for axes in (reading.axes, reading.devices)
        )
        # a device of other axes is turned by a constant before it is turned by its rotation
        rotations = quat.multiply(rotations, quat.from_matrix(world @ device.T))
    return replace(track, positions=positions, rotations=rotations)
