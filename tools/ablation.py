"""What each part of the body estimate gives: baked users of several suits, none of them in the databases.

    python tools/ablation.py TAKES_FOLDER SUBJECTS_1_2.npz LAFAN1.npz [--predictor P.npz] [--only SET ...]

The first database is of LAFAN1's subjects 1 and 2, mirrored, for users who are subject 3; the second of all of them,
for the others. Prints a row for each set and variant, with the figures of reports (docs/evaluation.md), and the
estimate's own joints as they are, which is what a method shows that plays its network's answers.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from footwork.core.body.edit import cut
from footwork.core.database.contacts import find_contacts
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.sidecar import load_database
from footwork.core.evaluation.evaluate import evaluate_take
from footwork.core.evaluation.true_estimate import true_estimate
from footwork.core.jobs import run
from footwork.core.maths import angles
from footwork.core.measure.catalogue import pool, summarise
from footwork.core.measure.measures import contact_speeds, jitter
from footwork.core.measure.metric import get
from footwork.core.mocap.take import Take
from footwork.core.mocap.takes import load_take
from footwork.core.recording.body_estimate import BodyEstimate
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording
from footwork.core.settings import BakeSettings
from footwork.nn.predictor import head_height, load_predictor, predict, shipped_predictor

MOST_S = 40.0
"""Of a take, its beginning."""
VR = ("spacepiratetrainer_0", "spacepiratetrainer_2", "beatsaber_4", "beatsaber_5", "boxvr_4", "generic_0")
SETS = {
    "LAFAN1 subject 3": [
        f"lafan1/*subject3*{kind}*.bvh" for kind in ("walk", "turn", "sideways", "jog", "slow", "backward")
    ],
    "FuBoT": [f"fubot_vr/{name}.bvh" for name in VR],
    "Xsens": ["xsens/JL_mm_run.bvh", "xsens/100STYLE_*.bvh"],
    "Bandai": [
        "bandai_namco/dataset-2_walk*normal_00[1-3].bvh",
        "bandai_namco/dataset-2_run_normal_00[1-3].bvh",
    ],
    "HDM05": ["hdm05/*sneak*.bvh", "hdm05/*jogLeftCircle*.bvh", "hdm05/*squat*01[34]*.bvh"],
}
"""Files of each set; crawling takes are left out."""
COLUMNS = {
    "legs": "lower_body_mpjpe_cm.mean",
    "frozen": "frozen_pose_lower_body_mpjpe_cm.mean",
    "phase": "phase_agreement",
    "hips": "hips_error_cm.mean",
    "yaw": "body_yaw_error_deg.mean",
    "skate": "true_contact_skate_cm_s.mean",
    "(true)": "true_contact_skate_cm_s.floor.mean",
    "jitter": "jitter",
    "(true) ": "jitter_floor",
    "changes": "transitions_per_s",
}

Predict = Callable[[Recording], BodyEstimate]


@dataclass(frozen=True)
class User:
    """A take and what a predictor says of its trackers."""

    take: Take
    recording: Recording
    estimate: BodyEstimate


def variants(user: User) -> Iterator[tuple[str, BodyEstimate, dict[str, Any]]]:
    """Name, estimate and settings of each row."""
    told = user.estimate
    yaws = BodyEstimate(told.yaws, told.doubt)
    yield "direction alone", yaws, {}
    yield "+ hips", replace(yaws, hips=told.hips), {}
    yield "+ feet", replace(yaws, feet=told.feet), {}
    yield "+ feet, standing", replace(yaws, feet=told.feet, standing=told.standing), {}
    yield "all", told, {}
    yield "all, greedy", told, {"search": "greedy"}
    yield "true estimate", true_estimate(user.take.motion, head_height(user.recording)), {}


def users_of(folder: Path, patterns: list[str], answer: Predict) -> list[User]:
    """The users of one set."""
    files = sorted(
        {file for pattern in patterns for file in folder.glob(pattern) if "ground" not in file.name}
    )
    users: list[User] = []
    for file in files:
        take = load_take(file, 60.0)
        take = replace(take, motion=cut(take.motion, 0, min(len(take.motion), round(MOST_S * 60.0))))
        recording = simulate_recording(take.motion, take.name)
        users.append(User(take, recording, answer(recording)))
    return users


def played_as_they_are(users: list[User]) -> str:
    """Hips, ankles and toes of the estimates: distance from the true ones, skate in the true contacts, jitter."""
    rows: list[tuple[float, ...]] = []
    for user in users:
        size, told = head_height(user.recording), user.estimate
        true = true_estimate(user.take.motion, size)
        if told.hips is None or told.feet is None or true.hips is None or true.feet is None:
            return "-"
        heads = user.take.motion.forward()[0][:, user.take.motion.skeleton.joint("head"), :2]

        def placed(estimate: BodyEstimate, size: float = size, heads: Any = heads) -> Any:
            assert estimate.hips is not None and estimate.feet is not None
            hips = estimate.hips.mean[:, None]
            feet = hips + estimate.feet.mean.reshape(len(hips), 4, 3)
            points = np.concatenate([hips, feet], axis=1) * size
            points[..., :2] = angles.turn(points[..., :2], estimate.yaws[:, None]) + heads[:, None]
            return points

        mine, theirs = placed(told), placed(true)
        stands = find_contacts(theirs[:, [2, 4]], 60.0)
        skates = [np.nanmean(contact_speeds(points[:, [2, 4]], stands, 60.0)) for points in (mine, theirs)]
        jitters = [jitter(points, 60.0).mean() for points in (mine, theirs)]
        rows.append((np.linalg.norm(mine - theirs, axis=-1).mean() * 100, *np.array(skates) * 100, *jitters))
    found = np.average(rows, axis=0, weights=[len(user.take.motion) for user in users])
    return "{:.1f} cm, skate {:.1f} ({:.1f}) cm/s, jitter {:.0f} ({:.0f})".format(*found)


def table(users: list[User], databases: list[MotionDatabase]) -> None:
    """Print the rows of one set."""
    print("  " + f"{'':<18}" + "".join(f"{name.strip():>9}" for name in COLUMNS) + f"{'x real time':>13}")
    rows: dict[str, list[Any]] = {}
    for user in users:
        for name, estimate, settings in variants(user):
            began = time.process_time()
            found = run(
                evaluate_take(
                    user.take, databases, lambda _, e=estimate: e, replace(BakeSettings(), **settings)
                )
            )
            spent = sum(found.report["timing_s"][key] for key in ("search", "blending", "rig", "keys"))
            rows.setdefault(name, []).append((found.values, spent, time.process_time() - began))
    seconds = sum(len(user.take.motion) for user in users) / 60.0
    for name, found in rows.items():
        metrics = summarise(pool([values for values, *_ in found]))
        cells = [get(metrics, path) for path in COLUMNS.values()]
        text = "".join(f"{'-':>9}" if cell is None else f"{cell:9.2f}" for cell in cells)
        print(f"  {name:<18}{text}{seconds / sum(spent for _, spent, _ in found):13.0f}", flush=True)
    print(f"  estimate's own joints: {played_as_they_are(users)}", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("folder", type=Path, metavar="TAKES_FOLDER")
    parser.add_argument("subjects", type=Path, metavar="SUBJECTS_1_2.npz")
    parser.add_argument("everyone", type=Path, metavar="LAFAN1.npz")
    parser.add_argument("--predictor", type=Path, metavar="P.npz", help="weights (default: those that ship)")
    parser.add_argument("--only", nargs="*", default=list(SETS), choices=list(SETS), metavar="SET")
    options = parser.parse_args()
    made = load_predictor(options.predictor) if options.predictor else shipped_predictor()
    bases = {path: load_database(path) for path in (options.subjects, options.everyone)}
    for name in options.only:
        users = users_of(options.folder, SETS[name], lambda recording: predict(made, recording))
        seconds = sum(len(user.take.motion) for user in users) / 60.0
        print(f"{name}: {len(users)} takes, {seconds:.0f} s", flush=True)
        table(users, [bases[options.subjects if "subject 3" in name else options.everyone]])


if __name__ == "__main__":
    main()
