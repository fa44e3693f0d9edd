"""Takes from FBX and glTF through Blender's importers: the motion that was exported, and nothing left behind."""

from __future__ import annotations

from pathlib import Path

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import preview
from footwork.bridge.importing import read_scene_take
from footwork.core.body.edit import resample
from footwork.core.body.pose import role_poses
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.mocap.takes import is_take, load_take
from mathutils import Vector

RATE = 24.0
MOTION = resample(demo_motion("turn", 3), RATE)
KINDS = (".fbx", ".glb", ".gltf")


def exported(path: Path, skin: bool = True) -> Path:
    """The motion on an armature of its own, as Blender's exporter writes it."""
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = round(RATE), 1.0
    take = Take("walker", "walker.bvh", "", MOTION, {}, ())
    none = np.zeros((len(MOTION), 2), dtype=np.bool_)
    obj = preview.show_take(take, none, "", scene.collection, scene)
    if skin:
        _skin(obj)
    obj.location, obj.rotation_euler = (0.4, -0.3, 0.0), (0.0, 0.0, 0.7)
    scene.frame_start, scene.frame_end = 1, len(MOTION)
    for other in scene.objects:
        other.select_set(True)
    if path.suffix == ".fbx":
        bpy.ops.export_scene.fbx(
            filepath=str(path),
            use_selection=True,
            object_types={"ARMATURE", "MESH"},
            bake_anim_simplify_factor=0.0,
        )
    else:
        kind = "GLB" if path.suffix == ".glb" else "GLTF_SEPARATE"
        bpy.ops.export_scene.gltf(
            filepath=str(path), export_format=kind, use_selection=True, export_force_sampling=True
        )
    return path


def _skin(obj: bpy.types.Object) -> None:
    """A triangle on each bone."""
    places, names = [], [bone.name for bone in obj.data.bones]
    for bone in obj.data.bones:
        places += [bone.head_local + Vector(way) for way in ((0, 0, 0), (0.02, 0, 0), (0, 0.02, 0.01))]
    mesh = bpy.data.meshes.new("skin")
    mesh.from_pydata(
        [tuple(p) for p in places], [], [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(names))]
    )
    skin = bpy.data.objects.new("skin", mesh)
    bpy.context.scene.collection.objects.link(skin)
    skin.parent = obj
    for index, name in enumerate(names):
        skin.vertex_groups.new(name=name).add([3 * index, 3 * index + 1, 3 * index + 2], 1.0, "REPLACE")
    skin.modifiers.new("Armature", "ARMATURE").object = obj
    bpy.context.view_layer.update()


def blocks() -> dict[str, list[str]]:
    names = [item.identifier for item in bpy.data.bl_rna.properties if item.type == "COLLECTION"]
    return {name: sorted(block.name_full for block in getattr(bpy.data, name)) for name in names}


def test_a_rest_that_is_but_one_of_the_poses_is_not_trusted(empty, tmp_path: Path) -> None:
    # the head looks far aside in the frame that the exporter is called at
    bpy.context.scene.frame_set(150)
    take = load_take(exported(tmp_path / "a.fbx", skin=False), scenes=read_scene_take)
    assert take.found["T-pose"].startswith("from the data")
    _, turns = role_poses(MOTION, ("hips", "head"))
    _, found = role_poses(take.motion, ("hips", "head"))
    count = min(len(found), len(turns))
    wanted, seen = (
        np.degrees(np.unwrap(quat.heading(q[:count, 1]) - quat.heading(q[:count, 0]))) for q in (turns, found)
    )
    # the mean of a take that looks aside more often stays: 94 degrees where the rest is trusted
    assert np.abs(seen - wanted).max() < 25.0


@pytest.mark.parametrize("suffix", KINDS)
def test_the_motion_comes_back(empty, tmp_path: Path, suffix: str) -> None:
    path = exported(tmp_path / f"a{suffix}")
    assert is_take(path)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 30, 5, 77
    scene.frame_set(9)
    bpy.context.view_layer.update()
    before, active = blocks(), bpy.context.view_layer.objects.active
    take = load_take(path, scenes=read_scene_take)
    assert blocks() == before
    assert (scene.render.fps, scene.frame_start, scene.frame_end, scene.frame_current) == (30, 5, 77, 9)
    assert bpy.context.scene == scene and bpy.context.view_layer.objects.active == active
    assert take.motion.fps == pytest.approx(RATE) and abs(len(take.motion) - len(MOTION)) <= 1
    roles = [role for role in MOTION.skeleton.roles if role in take.motion.skeleton.roles]
    assert {"hips", "head", "hand.L", "toe.R", "thigh.L"} <= set(roles)
    count = min(len(take.motion), len(MOTION))
    wanted, turns = (part[:count] for part in role_poses(MOTION, roles))
    places, found = (part[:count] for part in role_poses(take.motion, roles))
    # the armature that is shown faces -Y, and was turned and moved as an object
    yaw = np.median(quat.heading(quat.multiply(found[:, 0], quat.conjugate(turns[:, 0]))))
    turn = quat.from_yaw(yaw)
    shift = (places - quat.rotate(turn, wanted)).mean(axis=(0, 1))
    assert np.abs(places - quat.rotate(turn, wanted) - shift).max() < 2e-3
    off = quat.multiply(found, quat.conjugate(quat.multiply(turn, turns)))
    angles = np.degrees(np.linalg.norm(quat.to_rotation_vector(off), axis=-1)).max(axis=0)
    assert dict(zip(roles, angles.round(1).tolist(), strict=True)) == dict.fromkeys(roles, 0.0)


def test_what_is_no_take_is_refused_in_one_line(empty, tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.export_scene.fbx(filepath=str(tmp_path / "cube.fbx"))
    (tmp_path / "short.glb").write_bytes(b"glTF\x02\x00\x00\x00")
    (tmp_path / "text.fbx").write_text("; FBX 7.7.0 project file\n")
    (tmp_path / "cut.fbx").write_bytes((tmp_path / "cube.fbx").read_bytes()[:700])
    before = blocks()
    for name, words in (
        ("cube.fbx", "no skeleton"),
        ("short.glb", "cannot read it"),
        ("text.fbx", "cannot read it"),
        ("cut.fbx", "cannot read it"),
    ):
        with pytest.raises(InputError, match=words) as caught:
            load_take(tmp_path / name, scenes=read_scene_take)
        assert len(caught.value.lines) == 1 and name in str(caught.value)
        assert blocks() == before


def test_a_skeleton_without_motion_says_so(empty, tmp_path: Path) -> None:
    obj = bpy.data.objects.new("still", bpy.data.armatures.new("still"))
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    obj.data.edit_bones.new("one").tail = (0.0, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.export_scene.fbx(filepath=str(tmp_path / "still.fbx"), bake_anim=False)
    with pytest.raises(InputError, match="no motion of theirs"):
        load_take(tmp_path / "still.fbx", scenes=read_scene_take)


def test_the_list_of_takes_reads_them(empty, tmp_path: Path) -> None:
    exported(tmp_path / "walker.fbx")
    helpers.add_takes(tmp_path, "walker.fbx")
    row = bpy.context.scene.footwork.takes[0]
    assert row.state in ("OK", "DOUBT"), row.doubts
    assert row.seconds == pytest.approx((len(MOTION) - 1) / RATE, abs=0.05)
