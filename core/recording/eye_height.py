"""How high the headset is when its wearer stands upright."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..body.standing import standing_height
from ..maths import kinematics, quat
from .recording import Array, Mounts
from .timeline import Samples

_PLAUSIBLE_M = (1.0, 2.1)
_STANDING_M = 1.35
"""Lower than of any grown person but the smallest."""
_USUAL_M = 1.65
_FLOOR_TOLERANCE = 0.1
_LOW = 0.75
"""Of the standing height, below which a headset may lie."""
_STILL_M, _NUDGED_M, _NUDGED = 0.002, 0.01, np.radians(1.5)
"""Within a second. The quietest two seconds of people who wear one: 17 mm and 1.6 degrees."""
_NUDGED_S = 2
"""Seconds for which it must lie where it is never quite still."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """How tall the wearer stands, and where the floor is."""

    eye_height: float
    """Metres."""
    source: str
    """Where it comes from, for people."""
    lift: float
    """Metres to add to all heights so that the floor is at 0."""
    doubts: tuple[str, ...]


def calibrate(samples: Samples, given: float | None, stated: float | None, on_floor: bool) -> Calibration:
    """The eye height: given by the user, or stated in the file, or measured from the recording.

    Args:
        samples: the repaired recording, as looking ahead.
        given: metres, or None.
        stated: metres as the file has it, or None.
        on_floor: whether heights are above the floor; if not, the measured standing height is put at the eye
            height.
    """
    standing = headset_standing_height(samples)
    doubts: list[str] = []
    if given is not None:
        eye_height, source = given, "given"
    elif stated is not None:
        eye_height, source = stated, "stated in the file"
    elif on_floor:
        eye_height, source = standing, "standing height of the headset"
    else:
        # where nothing tells: between women's and men's mean
        eye_height, source = _USUAL_M, "assumed"
        doubts.append(
            f"heights are relative to the start: eye height {_USUAL_M} m assumed; give the wearer's"
        )
    if on_floor and abs(standing - eye_height) > _FLOOR_TOLERANCE * eye_height:
        doubts.append(
            f"headset stands at {standing:.2f} m, not near {eye_height:.2f} m: check unit and floor"
        )
    if source == "standing height of the headset" and eye_height < _STANDING_M:
        doubts.append(
            f"the headset is never higher than {eye_height:.2f} m: seated? give the wearer's standing eye height"
        )
    if not _PLAUSIBLE_M[0] <= eye_height <= _PLAUSIBLE_M[1]:
        doubts.append(
            f"eye height of {eye_height:.2f} m is implausible; give the wearer's, check unit and floor"
        )
    return Calibration(eye_height, source, 0.0 if on_floor else eye_height - standing, tuple(doubts))


def looking_ahead(samples: Samples, mounts: Mounts) -> Samples:
    """The samples with the headset where it would be, did its wearer look straight ahead.

    Who looks down lowers the headset, which sits before the head's joint, without being less tall.
    """
    head = quat.multiply(samples.rotations[:, 0], quat.conjugate(mounts.turns[0]))
    positions = samples.positions.copy()
    positions[:, 0] += mounts.offsets[0] * (0.0, 0.0, 1.0)
    positions[:, 0] -= quat.rotate(head, mounts.offsets[0])
    return replace(samples, positions=positions)


def headset_standing_height(samples: Samples) -> float:
    """Height of the headset, metres, while its wearer stands at ease."""
    head, valid = samples.positions[:, 0], samples.valid[:, 0]
    step = np.gradient(samples.times)
    speed = np.linalg.norm(kinematics.velocity(head, 1.0) / step[:, None], axis=-1)
    return standing_height(head[valid, 2], speed[valid])


def put_down(samples: Samples) -> float | None:
    """The time in seconds from which the headset lies still to the recording's end, or None while it is worn.

    A worn headset never stays within 2 mm for a second, except in mid-air on a stand; it must also lie low. One that is
    nudged, or whose tracking drifts, stays within a centimetre and turns by less than a person's head does.
    """
    times, head = samples.times, samples.positions[:, 0]
    standing = headset_standing_height(samples)
    start, still, seconds = None, False, 0
    for second in range(int(times[-1]) - 1, -1, -1):
        inside = (times >= second) & (times < second + 1)
        block = head[inside]
        if len(block) < 2 or block[0, 2] > _LOW * standing:
            break
        moved = float(np.ptp(block, axis=0).max())
        if moved > _STILL_M and (moved > _NUDGED_M or _turned(samples.rotations[inside, 0]) > _NUDGED):
            break
        still = still or moved <= _STILL_M
        start, seconds = float(second), seconds + 1
    return start if still or seconds >= _NUDGED_S else None


def _turned(rotations: Array) -> float:
    """The furthest that rotations `(N, 4)` are from the middle one, radians."""
    middle = rotations[len(rotations) // 2]
    return float(2.0 * np.arccos(np.clip(np.abs(rotations @ middle), 0.0, 1.0)).max())
