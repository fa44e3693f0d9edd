from __future__ import annotations

import json

import numpy as np
import pytest
from footwork.core.database.build import build_database
from footwork.core.database.describe import describe_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.mounts import SIMULATED_MOUNTS
from footwork.core.settings import DatabaseSettings


def build(*takes, **settings) -> MotionDatabase:
    return run(build_database(takes, DatabaseSettings(**settings), name="test"))


def straight(glide, as_take, velocity: tuple[float, float], rate_deg: float = 0.0, name: str = "straight"):
    """Slides at a velocity in its own axes while it turns."""
    yaws = np.radians(rate_deg) * np.arange(180) / 60.0
    c, s = np.cos(yaws), np.sin(yaws)
    steps = np.column_stack([c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]]) / 60.0
    return as_take(glide(np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)[:-1]]), yaws), name)


@pytest.mark.parametrize(
    ("velocity", "rate", "direction", "speed_from", "turn_from"),
    [
        ((0.0, 1.2), 0.0, "forward", 1.0, -15.0),
        ((0.0, -0.5), 60.0, "backward", 0.3, 45.0),
        ((-0.7, 0.0), -60.0, "left", 0.6, -90.0),
        ((2.5, 0.0), 0.0, "right", 2.0, -15.0),
    ],
)
def test_coverage_of_one_movement(
    glide, as_take, velocity, rate: float, direction: str, speed_from: float, turn_from: float
) -> None:
    coverage = describe_database(build(straight(glide, as_take, velocity, rate)))["coverage"]
    counts = np.array(coverage["frames"])
    where = np.unravel_index(counts.argmax(), counts.shape)
    assert counts.max() == counts.sum() == 180
    assert coverage["directions"][where[0]] == direction
    assert coverage["speed_borders_m_s"][where[1]] == speed_from
    assert coverage["turn_borders_deg_s"][where[2] - 1] == turn_from
    assert coverage["direction_shares"][direction] == 1.0
    assert coverage["turn_deg_s"]["median"] == pytest.approx(rate, abs=1e-2)
    assert coverage["standing_share"] == 0.0


def test_skate_floor_and_contacts(glide, as_take) -> None:
    # the whole body slides at 8 cm/s: below the threshold, so in contact, and skating as fast
    feet = describe_database(build(straight(glide, as_take, (0.0, 0.08))))["feet"]
    assert feet["contact_share"] == {"left": 1.0, "right": 1.0}
    assert feet["foot_skate_cm_s"] == pytest.approx(8.0, abs=0.01)
    assert feet["toe_height_m"]["median"] == pytest.approx(0.02, abs=1e-3)
    # at 30 cm/s there is no contact to skate in
    feet = describe_database(build(straight(glide, as_take, (0.3, 0.0))))["feet"]
    assert feet["airborne_share"] == 1.0
    assert feet["foot_skate_cm_s"] is None


def test_skate_does_not_see_the_seam_between_clips(glide, as_take) -> None:
    still = straight(glide, as_take, (0.0, 0.0), name="a")
    far = as_take(glide(np.full((180, 2), 9.0), np.full(180, 2.0)), "b")
    described = describe_database(build(still, far))
    assert described["feet"]["foot_skate_cm_s"] == 0.0
    assert described["coverage"]["standing_share"] == 1.0
    assert described["coverage"]["speed_m_s"]["max"] == 0.0


def test_contents(small: MotionDatabase) -> None:
    described = describe_database(small)
    text = json.dumps(described, allow_nan=False)
    assert json.loads(text) == described
    assert (described["frames"], described["seconds"]) == (3420, 57.0)
    assert described["found_frames"] == 3420 - 4 * 60
    assert [clip["mirrored"] for clip in described["clips"]] == [False, False, True, True]
    assert described["tags"] == ["demo", "päivä"]
    assert described["height_range"] == [0.8, 1.1]
    assert described["provenance"]["settings"]["mirror"] is True
    assert described["provenance"]["sources"][0]["name"] == "turn"
    assert np.sum(described["coverage"]["frames"]) == 3420
    # as much to the left as to the right
    assert described["coverage"]["turn_deg_s"]["min"] == -described["coverage"]["turn_deg_s"]["max"]


def test_headset_heights_are_the_simulated_headsets(as_take) -> None:
    motion = demo_motion("crouch")
    database = build(as_take(motion, "crouch"))
    told = describe_database(database)["headset_height_ratio"]
    positions, rotations = motion.forward()
    head = motion.skeleton.names.index("Head")
    expected = positions[:, head] + quat.rotate(rotations[:, head], SIMULATED_MOUNTS.offsets[0])
    ratios = expected[:, 2] / database.head_height
    for name, share in (("min", 0.0), ("p5", 5.0), ("median", 50.0), ("p95", 95.0), ("max", 100.0)):
        assert told[name] == pytest.approx(np.percentile(ratios, share), abs=1e-4)


def suggested(database: MotionDatabase) -> list[float]:
    return describe_database(database)["suggested_height_range"]


def test_suggested_height_ranges(as_take) -> None:
    crouch = suggested(build(as_take(demo_motion("crouch"), "crouch")))
    walk = suggested(build(as_take(demo_motion("walk"), "walk")))
    # the demo crouches by 36 to 38 % of the hips' height, a quarter of the headset's
    assert 0.65 < crouch[0] < crouch[1] < 0.85
    assert 0.85 < walk[0] < walk[1] <= 1.02
    for low, high in (crouch, walk):
        assert round(low * 100) == pytest.approx(low * 100)
        assert round(high * 100) == pytest.approx(high * 100)
