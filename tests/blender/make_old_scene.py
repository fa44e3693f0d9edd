"""Make the file that an upgrade is tested with: `python tests/blender/make_old_scene.py ROOT old_scene_N.blend`.

Run it with ROOT at the code before a new upgrade step, in the oldest Blender that Footwork supports, and put
old_scene_N.blend and .json, the values in it, beside this script: `test_upgrade.py` opens every `old_scene_N.blend`.
Every property of the scene's settings gets a value that is not its default; all names and paths are made up.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("BLENDER_USER_RESOURCES", tempfile.mkdtemp(prefix="footwork-"))
import bpy

BONES = (
    *("pelvis", "belly", "breast", "throat", "skull"),
    *(
        f"{part}_{side}"
        for side in "lr"
        for part in ("upperarm", "lowerarm", "palm", "thigh", "calf", "sole")
    ),
)
ROLES = ("hips", "spine1", "chest", "neck", "head")
SIDE_ROLES = ("upper_arm", "forearm", "hand", "thigh", "shin", "foot")
OBJECTS = {"rig": "Character", "ground": "Hill", "head": "Visor", "left": "Grip L", "right": "Grip R"}


def main(root: Path, target: Path) -> None:
    """Enable the extension at `root`, fill a scene, save it with its values."""
    folder = Path(os.environ["BLENDER_USER_RESOURCES"]) / "extensions" / "user_default"
    folder.mkdir(parents=True)
    (folder / "footwork").symlink_to(root.resolve())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    importlib.import_module("addon_utils").enable("bl_ext.user_default.footwork")
    scene = bpy.context.scene
    make_objects(scene)
    fill(scene.footwork)
    if "version" in scene.footwork.bl_rna.properties:
        scene.footwork.version = int(target.stem.rpartition("_")[2])
    for role, bone in zip(all_roles(), BONES, strict=True):
        setattr(scene.footwork.rig.footwork, role, bone)
    # without Blender's windows, which keep folders of the one who made the file
    bpy.data.libraries.write(str(target), {scene}, path_remap="NONE", compress=True)
    values = {"scene": read(scene.footwork), "roles": read(scene.footwork.rig.footwork)}
    target.with_suffix(".json").write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")


def all_roles() -> list[str]:
    """Names of the role map's properties, in the order of BONES."""
    return [*ROLES, *(f"{role}_{side}" for side in "LR" for role in SIDE_ROLES)]


def make_objects(scene: bpy.types.Scene) -> None:
    """A rig whose bones no naming family knows, ground, and three trackers."""
    rig = bpy.data.objects.new(OBJECTS["rig"], bpy.data.armatures.new("Bones"))
    mesh = bpy.data.meshes.new("Hill")
    mesh.from_pydata([(0, 0, 0), (3, 0, 0.4), (0, 2, 0.1)], [], [(0, 1, 2)])
    trackers = [bpy.data.objects.new(OBJECTS[name], None) for name in ("head", "left", "right")]
    for obj in (rig, bpy.data.objects.new(OBJECTS["ground"], mesh), *trackers):
        scene.collection.objects.link(obj)
    scene.collection.children.link(bpy.data.collections.new("Terrain"))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for number, name in enumerate(BONES):
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = (number, 0.1, 1.0), (number, 0.2, 1.3)
    bpy.ops.object.mode_set(mode="OBJECT")


def fill(group: bpy.types.PropertyGroup, number: int = 0) -> None:
    """Give every property a value that is not its default, depth first; `number` tells rows of a list apart."""
    # the path of the recording resets what was found in it
    for prop in sorted(group.bl_rna.properties, key=lambda prop: prop.identifier != "recording_path"):
        name = prop.identifier
        if prop.type == "COLLECTION":
            for row in range(3):
                fill(getattr(group, name).add(), row)
        elif prop.type == "POINTER" and name in OBJECTS:
            setattr(group, name, bpy.data.objects[OBJECTS[name]])
        elif prop.type == "POINTER" and prop.fixed_type.identifier == "Collection":
            setattr(group, name, bpy.data.collections["Terrain"])
        elif prop.type == "POINTER" and name != "rna_type":
            fill(getattr(group, name))
        elif prop.type != "POINTER":
            setattr(group, name, other_value(prop, number))
            assert getattr(group, name) != prop.default, name


def other_value(prop: bpy.types.Property, number: int) -> object:
    """A valid value of a property beside its default."""
    if prop.type == "BOOLEAN":
        return not prop.default
    if prop.type == "ENUM":
        others = [item.identifier for item in prop.enum_items if item.identifier != prop.default]
        return others[number % len(others)]
    if prop.type == "INT":
        return prop.default + 1
    if prop.type == "FLOAT":
        step = 0.0625 * (number + 1)
        return prop.default + step if prop.default + step < prop.hard_max else prop.default - step
    return (
        f"//made_up/{prop.identifier}_{number}"
        if prop.subtype == "FILE_PATH"
        else f"a {prop.identifier} {number}"
    )


def read(group: bpy.types.PropertyGroup) -> dict[str, object]:
    """Every value of a group, by name."""
    values: dict[str, object] = {}
    for prop in group.bl_rna.properties:
        value = getattr(group, prop.identifier)
        if prop.identifier == "rna_type":
            continue
        if prop.type == "COLLECTION":
            values[prop.identifier] = [read(row) for row in value]
        elif isinstance(value, bpy.types.ID):
            values[prop.identifier] = value.name
        elif prop.type == "POINTER":
            values[prop.identifier] = None if value is None else read(value)
        else:
            values[prop.identifier] = value
    return values


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]).resolve())
    sys.stdout.flush()
    # some bpy modules crash or hang while Python tears them down
    os._exit(0)
