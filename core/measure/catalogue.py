"""Every metric of a report by name: what it is, its unit, and which way is better.

Reports, comparisons, limits and docs/evaluation.md go by this table; `metrics.py` measures what is in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast


@dataclass(frozen=True, slots=True)
class Metric:
    """One metric."""

    label: str
    unit: str
    says: str
    """One sentence: what exactly was measured."""
    kind: str = "distribution"
    """"distribution" (mean, std, p95, max), "number" (a mean alone) or "count"."""
    better: str = "lower"
    """"lower", "higher" or "" where neither is."""


METRICS: dict[str, Metric] = {
    "root_error_cm": Metric(
        "root error to the target", "cm", "Hips on the ground to the target that the search was given"
    ),
    "root_to_head_cm": Metric(
        "root error to the head",
        "cm",
        "Hips on the ground to the centre of the tracked head on the ground (the paper's target)",
    ),
    "hips_error_cm": Metric("root error to the true hips", "cm", "Hips to the true hips, on the ground"),
    "matched_root_error_cm": Metric(
        "root error of the matched motion",
        "cm",
        "The same as the first, before the avatar was put under the headset: what alpha bounds",
    ),
    "yaw_error_deg": Metric(
        "yaw error to the prediction", "°", "Heading of the hips to the predicted body orientation"
    ),
    "body_yaw_error_deg": Metric(
        "yaw error to the truth", "°", "Heading of the hips to that of the true hips"
    ),
    "orientation_error_deg": Metric(
        "orientation error", "°", "Predicted body orientation to the heading of the true hips"
    ),
    "orientation_doubt_deg": Metric(
        "orientation doubt", "°", "Deviation that the predictor itself expects of the body orientation"
    ),
    "foot_skate_cm_s": Metric(
        "foot skate",
        "cm/s",
        "Horizontal speed of toes while the matched motion's contacts say that they stand",
    ),
    "nsm_skate_cm_s": Metric(
        "skate weighted by height",
        "cm/s",
        "v (2 - 2^(h / 2.5 cm)) of both toes over all frames, 0 above 2.5 cm",
    ),
    "skating_ratio": Metric(
        "skating ratio",
        "",
        "Share of frames in which a toe below 5 cm is faster than 50 cm/s",
        kind="number",
    ),
    "slide_per_contact_cm": Metric(
        "slide in a contact", "cm", "Way of the toe over the ground from the start of a contact to its end"
    ),
    "floating_cm": Metric("floating", "cm", "Height of toes in contact above where they are in T-pose"),
    "sinking_cm": Metric("sinking", "cm", "Depth of toes in contact below where they are in T-pose"),
    "penetration_cm": Metric("below the floor", "cm", "Depth of the lower of toe and toe tip, all frames"),
    "head_position_error_cm": Metric("head error", "cm", "Head joint to where the headset puts it"),
    "head_rotation_error_deg": Metric("head error", "°", "Head joint to how the headset turns it"),
    "hand_position_error_cm": Metric("hand error", "cm", "Wrists to where the controllers put them"),
    "hand_position_error_in_reach_cm": Metric(
        "hand error in reach", "cm", "The same where the arm is long enough"
    ),
    "hand_rotation_error_deg": Metric("hand error", "°", "Wrists to how the controllers turn them"),
    "unreachable_fraction": Metric(
        "out of reach", "", "Share of tracked hands farther away than the arm is long", kind="number"
    ),
    "lower_body_mpjpe_cm": Metric(
        "lower body MPJPE", "cm", "Hips, legs and feet to the true ones in the world, not aligned"
    ),
    "upper_body_mpjpe_cm": Metric("upper body MPJPE", "cm", "The other joints, likewise"),
    "mpjpe_cm": Metric("MPJPE", "cm", "All joints, likewise"),
    "mpjre_deg": Metric("MPJRE", "°", "Components of local rotation vectors, absolute differences"),
    "mpjae_deg": Metric("MPJAE", "°", "Geodesic angle between local rotations"),
    "mpjve_cm_s": Metric("MPJVE", "cm/s", "Joint velocities to the true ones"),
    "hips_height_error_cm": Metric("hips height error", "cm", "Height of the hips to the true one"),
    "knee_error_deg": Metric("knee bend error", "°", "Angle between thigh and shin to the true one"),
    "jitter": Metric("jitter", "m/s³", "Third derivative of joint positions", kind="number"),
    "transitions_per_s": Metric(
        "transitions", "1/s", "Changes of place in the databases per second", kind="number"
    ),
    "pose_jump": Metric(
        "pose jump", "", "Pose features of a transition against what would have followed, normalised"
    ),
    "poses_used": Metric("poses used", "", "Different frames of the databases", kind="count", better=""),
    "clamped_fraction": Metric(
        "held at alpha", "", "Share of frames in which the root was held at alpha", kind="number"
    ),
}

STATISTICS = ("mean", "std", "p95", "max")


def get(metrics: Mapping[str, Any], path: str) -> float | None:
    """The number at `name`, `name.mean` or `name.floor.mean` of a report's `metrics`; None where there is
    none, or nothing was measured."""
    name, *rest = path.split(".")
    value: Any = metrics.get(name)
    for key in rest:
        if not isinstance(value, Mapping):
            return None
        inner = cast(Mapping[str, Any], value)
        value = inner.get(key) if inner.get("count") != 0 else None
    return float(value) if isinstance(value, int | float) else None
