"""Train the motion model that ships with Footwork, on takes whose licences allow it and on no others.

    python tools/train_motion.py TAKES_FOLDER [--steps 20000] [--seed 0] [-o MODEL.npz]

Needs torch. Same takes and same torch give the same weights. By default they replace those in nn/weights.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import motion_data
from footwork.nn.motion.decoder import MotionModel, save_model
from footwork.nn.train.motion import train_motion

WEIGHTS = Path(__file__).parents[1] / "nn" / "weights" / "motion.npz"
LIMITS = (
    "Locomotion of adults on a flat floor at 0 to 4 m/s, crouching to 0.7 of the hips' height; "
    "no stairs, jumps, sitting, lying or kneeling; hands hold nothing; legs of one body, 1.70 m tall."
)


def main() -> None:
    """Train and write."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument(
        "folder", type=Path, metavar="TAKES_FOLDER", help="has the folders of motion_data.SOURCES"
    )
    parser.add_argument("--steps", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-o", "--output", type=Path, default=WEIGHTS)
    options = parser.parse_args()
    if not options.folder.is_dir():
        parser.error(f"{options.folder}: no such folder")
    stretches, sources = motion_data.load(options.folder)
    provenance = {
        "takes": [
            {"name": name, "sha256": sha256, "licence": licence}
            for name, (sha256, licence) in sources.items()
        ],
        "frames": sum(len(item.root) for item in stretches),
        "steps": options.steps,
        "seed": options.seed,
        "licence": "GPL-3.0-or-later, as Footwork; see the takes for those whom to credit",
        "limits": LIMITS,
    }
    began = time.time()

    def told(step: int, loss: float, model: MotionModel) -> None:
        print(f"{step:6d} loss {loss:.4f}  {time.time() - began:.0f} s", flush=True)
        if step % 5000 == 0:
            save_model(options.output, model)

    model = train_motion(
        motion_data.arrays(stretches),
        motion_data.PEOPLE,
        provenance,
        steps=options.steps,
        seed=options.seed,
        told=told,
    )
    save_model(options.output, model)


if __name__ == "__main__":
    main()
