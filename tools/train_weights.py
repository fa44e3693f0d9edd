"""Train the predictors that ship with Footwork, on the takes whose licences allow it and on no others.

    python tools/train_weights.py TAKES_FOLDER [look-ahead] [causal] [paper]

Needs torch. Same takes and same torch give the same weights. They replace those in nn/weights.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from footwork.core.jobs import run
from footwork.core.mocap.take import Take
from footwork.core.mocap.takes import load_take
from footwork.nn.settings import TrainSettings
from footwork.nn.train.job import train_predictor

CMU = "CMU: free for any use, credit mocap.cs.cmu.edu"
FUBOT = "MIT, (c) 2021 Tomiha (FuBoT-VR)"
ALLOWED = {
    "xsens/JL_mm_run.bvh": "MIT, (c) 2023 Reiya Itatani",
    "xsens/100STYLE_*.bvh": 'CC BY 4.0, "The 100STYLE Dataset", Ian Mason',
    "fubot_vr/*.bvh": FUBOT,
    "cmu/*.bvh": CMU,
    "cmu/basketball/*.bvh": CMU,
    "cmu/dance_and_martial/*.bvh": CMU,
    "cmu/walks/*.bvh": CMU,
    "cmu/more/*.bvh": CMU,
    "o3de/*.bvh": "MIT, Open 3D Engine contributors (elected from Apache-2.0 or MIT)",
    "reactidle/*.bvh": "MIT, (c) 2025 RSAIT",
}
"""Patterns of take files below the folder, and their licence. Curation leaves out what has drifted."""
HELD_OUT = ("006_12", "007_10", "martial_08", "salsa_14", "100STYLE_Neutral_FW")
"""Takes kept back to choose the best moment of a training."""
SETTINGS = {
    "look-ahead": TrainSettings(
        kind="look-ahead", voters=2, hidden=512, epochs=30, time_limit=3600.0, patience=1000
    ),
    "causal": TrainSettings(kind="causal", hidden=512, epochs=30, time_limit=3600.0, patience=1000),
    "paper": TrainSettings(kind="paper", time_limit=3600.0, patience=1000),
}
WEIGHTS = Path(__file__).parents[1] / "nn" / "weights"


def main() -> None:
    """Train the kinds named on the command line, or all."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument(
        "folder",
        type=Path,
        metavar="TAKES_FOLDER",
        help="has the folders xsens, fubot_vr, cmu, o3de and reactidle",
    )
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"{', '.join(SETTINGS)} (default: all)")
    options = parser.parse_args()
    folder, kinds = options.folder, options.kinds or list(SETTINGS)
    unknown = [kind for kind in kinds if kind not in SETTINGS]
    if unknown:
        parser.error(f"{unknown[0]} is none of {', '.join(SETTINGS)}")
    if not folder.is_dir():
        parser.error(f"{folder}: no such folder")
    takes: list[Take] = []
    licences: dict[str, str] = {}
    for pattern, licence in ALLOWED.items():
        for file in sorted(folder.glob(pattern)):
            take = load_take(file)
            takes.append(take)
            licences[take.name] = licence
    training = [take for take in takes if take.name not in HELD_OUT]
    testing = [take for take in takes if take.name in HELD_OUT]
    for kind in kinds:
        job = train_predictor(
            training, SETTINGS[kind], WEIGHTS / f"{kind}.npz", held_out=testing, licences=licences
        )
        report = run(job, lambda fraction, message: print(f"{fraction:6.1%} {message}", flush=True))
        print(report)


if __name__ == "__main__":
    main()
