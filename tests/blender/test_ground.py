"""The ground of a scene, and a bake that stands on it."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from footwork.bridge import ground
from footwork.core.errors import InputError
from footwork.operators.bake import REPORT
from mathutils import Matrix, Vector


def mesh(scene: bpy.types.Scene, name: str, corners, faces) -> bpy.types.Object:
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def hill(scene: bpy.types.Scene) -> bpy.types.Object:
    """The plane z = 0.5 x, 4 m wide, as a scaled object."""
    obj = mesh(scene, "Hill", [(-1, -1, -0.5), (1, -1, 0.5), (1, 1, 0.5), (-1, 1, -0.5)], [(0, 1, 2, 3)])
    obj.matrix_world = Matrix.Scale(2.0, 4)
    bpy.context.view_layer.update()
    return obj


def test_heights_and_normals_of_a_slope(empty) -> None:
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (50, 2))
    found = ground.chosen_ground(empty, [hill(empty)], None)
    heights, normals = found(points)
    assert np.abs(heights - 0.5 * points[:, 0]).max() < 1e-5
    assert np.abs(normals - np.array([-0.5, 0.0, 1.0]) / np.sqrt(1.25)).max() < 1e-5
    # half a metre to the unit: half as large in metres
    heights, normals = ground.chosen_ground(empty, [empty.objects["Hill"]], None, 0.5)(points)
    inside = np.abs(points).max(axis=-1) < 1.0
    assert np.abs(heights - 0.5 * points[:, 0])[inside].max() < 1e-5
    assert np.isnan(heights[~inside]).all() and np.abs(normals[inside] @ [0.5, 0.0, -1.0]).min() > 1.1


def test_the_highest_of_a_collection_counts_and_nothing_below_is_nan(empty) -> None:
    terrain = bpy.data.collections.new("Terrain")
    empty.collection.children.link(terrain)
    for height in (0.0, 3.0):
        slope = hill(empty)
        slope.location.z = height
        terrain.objects.link(slope)
    bpy.context.view_layer.update()
    heights, normals = ground.chosen_ground(empty, [None, terrain], None)(np.array([[0.0, 0.0], [50.0, 0.0]]))
    assert heights[0] == pytest.approx(3.0, abs=1e-5) and np.isnan(heights[1])
    assert normals[1].tolist() == [0.0, 0.0, 1.0]
    assert ground.chosen_ground(empty, [None, None], None) is None


def test_modifiers_count_and_what_hangs_on_the_rig_does_not(empty) -> None:
    slope, hat = hill(empty), hill(empty)
    lifted = slope.modifiers.new("Lift", "DISPLACE")
    lifted.direction, lifted.strength, lifted.mid_level = "Z", 0.25, 0.0
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    empty.collection.objects.link(rig)
    hat.parent, hat.location.z = rig, 5.0
    bpy.context.view_layer.update()
    found = ground.chosen_ground(empty, [empty.collection], rig)
    assert found(np.zeros((1, 2)))[0] == pytest.approx([0.5], abs=1e-5)


def test_what_is_no_ground_is_refused(empty) -> None:
    empty.collection.objects.link(bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT")))
    for chosen in (empty.objects["Light"], bpy.data.collections.new("Nothing")):
        with pytest.raises(InputError, match=f"{chosen.name}: it has no surface to stand on"):
            ground.chosen_ground(empty, [chosen], None)
    stray = bpy.data.objects.new("Stray", bpy.data.meshes.new("Stray"))
    with pytest.raises(InputError, match="Stray: it is not in this scene"):
        ground.chosen_ground(empty, [stray], None)


@pytest.fixture
def hills(empty) -> bpy.types.Object:
    """A tilted, displaced grid on a slope of 0.2, 24 units wide."""
    side = 120
    places = np.linspace(-12.0, 12.0, side + 1)
    corners = [(x, y, 0.2 * y + 0.1 * np.sin(2.0 * x) * np.cos(1.5 * y)) for x in places for y in places]
    rows = [i * (side + 1) + j for i in range(side) for j in range(side)]
    obj = mesh(empty, "Hills", corners, [(k, k + side + 1, k + side + 2, k + 1) for k in rows])
    lift = obj.modifiers.new("Lift", "DISPLACE")
    lift.direction, lift.strength, lift.mid_level = "Z", 0.4, 0.0
    bpy.context.view_layer.update()
    return obj


@pytest.mark.parametrize("unit", [1.0, 0.5])
def test_planted_toes_stand_on_the_mesh(empty, ready, hills, unit: float) -> None:
    empty.unit_settings.system, empty.unit_settings.scale_length = "METRIC", unit
    bpy.ops.footwork.bake()
    ready.ground, rig = hills, ready.rig
    rest = [(rig.matrix_world @ rig.data.bones[name].head_local).z for name in ("LeftToe", "RightToe")]
    bpy.ops.footwork.bake()
    toes, above = [], []
    surface = hills.evaluated_get(bpy.context.evaluated_depsgraph_get())
    for frame in range(empty.frame_start, empty.frame_end + 1, 2):
        empty.frame_set(frame)
        body = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
        row = [body.matrix_world @ body.pose.bones[name].head for name in ("LeftToe", "RightToe")]
        toes.append([list(toe) for toe in row])
        hits = [surface.ray_cast(toe + Vector((0, 0, 5)), Vector((0, 0, -1))) for toe in row]
        above.append([(toe - hit[1]).dot(hit[2]) for toe, hit in zip(row, hits, strict=True)])
    toes, away = np.array(toes) * unit, (np.array(above) - rest) * unit
    still = np.linalg.norm(np.diff(toes, axis=0), axis=-1) < 1e-4
    assert still.mean() > 0.3
    assert np.abs(away[1:][still]).max() < 5e-3 and away.min() > -5e-3
    assert np.ptp(toes[..., 2]) > 0.3
    metrics = json.loads(bpy.data.texts[REPORT].as_string())["metrics"]
    assert metrics["head_position_error_cm"]["max"] < 0.1 and metrics["penetration_cm"]["max"] < 2.0


def test_a_mesh_that_ends_is_told_and_a_bad_ground_writes_nothing(empty, ready) -> None:
    ready.ground = mesh(
        empty, "Slab", [(-1, -1, 0.1), (1, -1, 0.1), (1, 1, 0.1), (-1, 1, 0.1)], [(0, 1, 2, 3)]
    )
    bpy.ops.footwork.bake()
    assert "no ground under the feet for" in bpy.data.texts[REPORT].as_string()
    ready.ground, before = None, len(bpy.data.actions)
    ready.ground_collection = bpy.data.collections.new("Nothing")
    with pytest.raises(RuntimeError, match="Nothing: it has no surface"):
        bpy.ops.footwork.bake()
    assert len(bpy.data.actions) == before
