"""A batch job with Footwork's own operators: `blender --background --python example_job.py -- ARGUMENTS`.

    blender --background --python-exit-code 1 --python docs/example_job.py -- \\
        --takes walk.bvh turn.bvh --recording session.csv --rig hero.fbx --output baked.blend

Every button of the panel is such an operator, every control a property of `scene.footwork`. Bad input raises
RuntimeError, which `--python-exit-code` turns into Blender's exit code.
"""

import argparse
import sys
from pathlib import Path

import bpy


def main() -> None:
    """Build a database from takes, bake a recording on a rig, save."""
    parser = argparse.ArgumentParser(prog="example_job.py")
    parser.add_argument("--takes", nargs="+", type=Path, required=True)
    parser.add_argument("--recording", type=Path, required=True)
    parser.add_argument(
        "--rig", type=Path, help=".blend, .fbx or .glb; default: an armature with the database's proportions"
    )
    parser.add_argument("--alpha", type=float, default=0.3, help="position accuracy, metres")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    output = options.output.resolve()

    bpy.ops.wm.read_homefile(use_empty=True)
    if options.rig:
        load(str(options.rig.resolve()))
    # where extensions are not enabled in the preferences, as with bpy as a Python module
    if not hasattr(bpy.types.Scene, "footwork"):
        bpy.ops.preferences.addon_enable(module="bl_ext.user_default.footwork")

    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = 60, 1.0
    footwork = scene.footwork
    footwork.rig = next((obj for obj in scene.objects if obj.type == "ARMATURE"), None)

    for take in options.takes:
        bpy.ops.footwork.add_takes(filepath=str(take.resolve()))
    footwork.database_settings.mirror = True
    bpy.ops.footwork.build_database(filepath=str(output.with_suffix(".npz")))

    bpy.ops.footwork.load_recording(filepath=str(options.recording.resolve()))
    footwork.bake.alpha = options.alpha
    bpy.ops.footwork.bake()

    for figure in footwork.figures:
        print(f"{figure.name:<18} {figure.value:<14} {figure.detail}")
    bpy.ops.wm.save_as_mainfile(filepath=str(output), copy=True)


def load(rig: str) -> None:
    """Open or import the file with the rig."""
    if rig.endswith(".blend"):
        bpy.ops.wm.open_mainfile(filepath=rig)
    elif rig.endswith(".fbx"):
        bpy.ops.import_scene.fbx(filepath=rig)
    else:
        bpy.ops.import_scene.gltf(filepath=rig)


main()
