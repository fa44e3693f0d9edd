"""A hundred invented layouts of one movement: read right, asked about or refused; none wrong in silence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.cut import cut
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.read import read_recording
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording

from .own_layouts import LAYOUTS, Motion

LONGEST_S = 20.0
NOT_READ = {
    "clocks: frames": "asked",
    "one row a device: frame": "asked",
    "one row a device: paths": "asked",
    "matrices: 3x3 from 1": "refused",
    "matrices: 4x4 from 1": "refused",
    "matrices: 4x4 by columns": "refused",
    "angles: rotation vector": "doubted",
}
"""What becomes of those that are not read right: frames have no times; the others could be read."""


@pytest.fixture(scope="module")
def truth() -> Recording:
    return cut(simulate_recording(demo_motion("turn", 3), "turn", DEVICE_MOUNTS), 0.0, LONGEST_S)


def off(found: Recording, truth: Recording) -> str:
    """What differs from the truth but for place and heading; "" for nothing."""
    if abs(found.times[-1] - truth.times[-1]) > 0.05:
        return f"{found.times[-1]:.2f} s long"
    count = min(len(found), len(truth))
    back = [
        np.broadcast_to(quat.from_yaw(-quat.heading(r.rotations[:1, :1])), (count, 3, 4))
        for r in (found, truth)
    ]
    places = [
        quat.rotate(b, r.positions[:count] - r.positions[:1, :1])
        for b, r in zip(back, (found, truth), strict=True)
    ]
    turns = [quat.multiply(b, r.rotations[:count]) for b, r in zip(back, (found, truth), strict=True)]
    known = found.valid[:count] & truth.valid[:count]
    apart = np.median(np.linalg.norm(places[0] - places[1], axis=-1)[known])
    turned = np.degrees(
        np.median(2.0 * np.arccos(np.clip(np.abs((turns[0] * turns[1]).sum(-1)), 0, 1))[known])
    )
    return "" if apart < 0.005 and turned < 1.0 else f"{100 * apart:.0f} cm, {turned:.0f} degrees off"


def outcome(path: Path, truth: Recording) -> str:
    """ "right", "doubted: ...", "asked: ...", "refused: ..." or "SILENT: ..."."""
    try:
        found = read_recording(path)
    except InputError as error:
        asks = any(
            f"--{option}" in str(error) for option in ("axes", "unit", "rotation", "rate", "up", "swap")
        )
        return f"{'asked' if asks else 'refused'}: {str(error).removeprefix(str(path))}"
    wrong = off(found, truth)
    if not wrong:
        return "right"
    return f"doubted: {wrong}; {found.doubts}" if found.doubts else f"SILENT: {wrong}; {found.found}"


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_layout_is_read_right_or_not_in_silence(name: str, truth: Recording, tmp_path: Path) -> None:
    files = LAYOUTS[name](Motion(truth.times, truth.positions, truth.rotations))
    place = tmp_path / "recording"
    if isinstance(files, bytes):
        place.write_bytes(files)
    else:
        for file, content in files.items():
            (place / file).parent.mkdir(parents=True, exist_ok=True)
            (place / file).write_bytes(content)
    told = outcome(place, truth)
    assert told.partition(":")[0] == NOT_READ.get(name, "right"), told
