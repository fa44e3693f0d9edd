"""From nothing to an animated character: starter motion, an example recording, a bake on a mannequin, pictures.

Writes into the output folder: the takes (.bvh), the databases (.npz), the recording (.csv), demo.blend, demo.mp4,
demo.png (a contact sheet) and report.json.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import bpy
import numpy as np
from footwork.cli import main as footwork
from render import contact_sheet, film, hushed, stage

MADE = {
    "demo.blend": "the scene with the animated character: open it in Blender",
    "report.json": "how good the bake is, as printed above",
    "demo.png": "twelve moments of it",
    "demo.mp4": "a film of it",
}


def verb(*arguments: str) -> None:
    """Run one verb of the command line; stop at the first that fails."""
    print("\n$ footwork", " ".join(arguments), flush=True)
    code = footwork(arguments)
    if code:
        finish(code)


def finish(code: int) -> None:
    """End without Python's teardown, at which some bpy modules crash or hang."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def pictures(out: Path) -> None:
    """The contact sheet and the film of the baked scene."""
    bpy.ops.wm.open_mainfile(filepath=str(out / "demo.blend"))
    scene = bpy.context.scene
    camera = stage(scene)
    frames = np.linspace(scene.frame_start, scene.frame_end, 12).round().astype(int)
    contact_sheet(scene, camera, frames, out / "demo.png")
    film(scene, camera, out / "demo.mp4")


def main() -> None:
    """Run the demo."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("out"), help="folder to write into")
    parser.add_argument("--no-pictures", action="store_true", help="leave out the film and the contact sheet")
    options = parser.parse_args()
    out: Path = options.output
    out.mkdir(parents=True, exist_ok=True)
    verb("starter", "-o", str(out))
    databases = [
        part for path in sorted(out.glob("starter_*.npz"), reverse=True) for part in ("--database", str(path))
    ]
    verb(
        "bake",
        str(out / "example.csv"),
        *databases,
        "-o",
        str(out / "demo.blend"),
        "--json",
        str(out / "report.json"),
    )
    made = ["demo.blend", "report.json"]
    if not options.no_pictures:
        print("\nrendering a contact sheet and a film, which takes a minute or two ...", flush=True)
        with hushed():
            pictures(out)
        made += ["demo.png", "demo.mp4"]
    width = max(len(str(out / name)) for name in made)
    print("\nMade:")
    for name in made:
        print(f"  {out / name!s:<{width}} {MADE[name]}")
    finish(0)


if __name__ == "__main__":
    main()
