"""Every control once: default, bounds, unit and help. UI properties and command-line flags are made from here."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from .errors import InputError
from .methods import FOOT_PLANS, SEARCHES


def setting(
    default: Any,
    label: str,
    help: str,
    *,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
    choices: Mapping[str, str] | None = None,
) -> Any:
    """A dataclass field that knows how to be shown.

    Args:
        default: its value when nothing is said; also gives its type (float, int, bool or str).
        label: name in the user interface.
        help: one sentence without a final period, the tooltip.
        low: least allowed value.
        high: greatest allowed value.
        unit: "m", "s", "1/s", "frames", "m/s", "deg" or "".
        choices: allowed values of a str, each with its own tooltip.
    """
    metadata = {"label": label, "help": help, "low": low, "high": high, "unit": unit, "choices": choices}
    return field(default=default, metadata=metadata)


def check(settings: Any) -> None:
    """Raise InputError for the first field of a settings dataclass that is out of its bounds."""
    for item in fields(settings):
        value, meta = getattr(settings, item.name), item.metadata
        name = item.name.replace("_", "-")
        if meta["choices"] is not None and value not in meta["choices"]:
            raise InputError(f"{name}: {value!r} is none of {', '.join(meta['choices'])}")
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{name}: {value} is not a finite number")
        if (meta["low"] is not None and value < meta["low"]) or (
            meta["high"] is not None and value > meta["high"]
        ):
            raise InputError(
                f"{name}: {value:g} is outside {meta['low']:g} to {meta['high']:g} {meta['unit']}".rstrip()
            )


@dataclass(frozen=True, slots=True)
class DatabaseSettings:
    """How takes become a motion database."""

    fps: float = setting(60.0, "Rate", "Frames per second of the database", low=10.0, high=240.0, unit="fps")
    mirror: bool = setting(False, "Mirror", "Add the mirror image of every take")
    contact_speed: float = setting(
        0.15, "Contact Speed", "A toe slower than this is on the ground", low=0.01, high=2.0, unit="m/s"
    )
    contact_window: float = setting(
        13 / 60, "Contact Window", "Length of the median filter over contacts", low=0.0, high=1.0, unit="s"
    )
    root_smoothing: float = setting(
        0.0,
        "Root Smoothing",
        "Savitzky-Golay window over the virtual root's path, 0 for none as in the paper",
        low=0.0,
        high=2.0,
        unit="s",
    )
    body_height: float = setting(
        1.0,
        "Body Height",
        "Share of the standing eye height that the takes are brought to: 0.7 makes crouched walks of walks, 1.04 walks "
        "on tip-toe; 1 leaves them as they are",
        low=0.6,
        high=1.06,
    )
    height_low: float = setting(
        0.0,
        "From",
        "Least headset height over standing eye height for which this database is used",
        low=0.0,
        high=2.0,
    )
    height_high: float = setting(
        2.0,
        "To",
        "Headset height over standing eye height from which this database is no longer used",
        low=0.0,
        high=2.0,
    )


@dataclass(frozen=True, slots=True)
class BakeSettings:
    """How a recording becomes an animation."""

    alpha: float = setting(
        0.3,
        "Position Accuracy",
        "Alpha: the root of the matched motion never leaves its target by more than this; by less on a small rig",
        low=0.01,
        high=2.0,
        unit="m",
    )
    beta: float = setting(
        4.6,
        "Responsiveness",
        "Beta: how fast the causal trajectory follows the headset, per second",
        low=0.1,
        high=50.0,
        unit="1/s",
    )
    trajectory: str = setting(
        "look-ahead",
        "Trajectory",
        "Where the query's future positions and directions come from",
        choices={
            "causal": "Extrapolate from the smoothed past, as in the paper",
            "look-ahead": "Read the recorded future",
        },
    )
    target: str = setting(
        "body",
        "Target",
        "Which point of the user the avatar's root follows, within alpha",
        choices={
            "body": "The body under the head, which leans as the databases' people do",
            "head": "The centre of the head, as in the paper",
        },
    )
    smoothing: str = setting(
        "spring",
        "Smoothing",
        "How velocity and direction are smoothed for the causal trajectory",
        choices={
            "spring": "Critically damped spring, as in the paper's results",
            "exponential": "Exponential decay, as in the paper's equations",
        },
    )
    search: str = setting(
        "path",
        "Search",
        "How the frames to play are chosen",
        choices=SEARCHES,
    )
    search_every: float = setting(
        10 / 60, "Search Every", "Time between two searches", low=1 / 240, high=2.0, unit="s"
    )
    halflife: float = setting(
        0.1,
        "Blend Half-life",
        "Half-life of the inertialization at transitions",
        low=0.01,
        high=1.0,
        unit="s",
    )
    adjustment: float = setting(
        0.1,
        "Root Adjustment",
        "Share of the character's own speed by which its root may be moved towards the user",
        low=0.0,
        high=1.0,
    )
    weight_trajectory_positions: float = setting(
        1.0, "Positions", "Weight of the future positions", low=0.0, high=100.0
    )
    weight_trajectory_directions: float = setting(
        1.0, "Directions", "Weight of the future directions", low=0.0, high=100.0
    )
    weight_feet: float = setting(1.0, "Feet", "Weight of feet positions and velocities", low=0.0, high=100.0)
    weight_hips: float = setting(1.0, "Hips", "Weight of the hips' velocity", low=0.0, high=100.0)
    step_weight: float = setting(
        1.0,
        "Follow Steps",
        "Weight of where the trackers tell that the user's feet are; 0 leaves steps to the trajectory, as in the paper",
        low=0.0,
        high=10.0,
    )
    height_margin: float = setting(
        0.02,
        "Height Margin",
        "How far past a height range's border before the database changes",
        low=0.0,
        high=0.5,
    )
    scale_to_rig: bool = setting(
        True,
        "Scale to Rig",
        "Scale the recording about the floor by the height of the rig's head over that of the user's",
    )
    feet: str = setting("planted", "Feet", "Where the feet go", choices=FOOT_PLANS)
    unlock_distance: float = setting(
        0.2,
        "Unlock Distance",
        "A locked foot is let go when the motion leaves it this far behind, on a body of 1.7 m",
        low=0.0,
        high=1.0,
        unit="m",
    )
    arms: bool = setting(True, "Hands", "Reach for the controllers")
    head: bool = setting(True, "Head", "Put the head at the headset")


PAPER: Mapping[str, Any] = {
    "search": "greedy",
    "trajectory": "causal",
    "smoothing": "spring",
    "target": "head",
    "step_weight": 0.0,
}
"""The bake settings that make the search the paper's."""
BAKE_PRESETS: Mapping[str, Mapping[str, Any]] = {
    "Default": {},
    "As in the Paper": PAPER,
    "Close to the User": {"alpha": 0.1},
}
"""Named sets of bake settings: what they change from the defaults."""
