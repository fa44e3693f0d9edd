"""Recordings from and to scene objects, and the ground under points."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from footwork.bridge import ground, objects
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from mathutils import Matrix, Vector


@pytest.fixture
def simulated():
    motion = demo_motion("walk", 0)
    return simulate_recording(motion, "walk")


def test_a_recording_shown_as_empties_reads_back(empty, simulated) -> None:
    empties = objects.show_recording(simulated, empty)
    empty.frame_end = round(simulated.times[-1] * 60.0) + 1
    empty.frame_set(17)
    back = objects.recording_from_objects(empty, empties)
    truth = resample(simulated, 60.0)
    assert empty.frame_current == 17 and len(back) == len(truth)
    assert np.abs(back.positions - truth.positions).max() < 1e-4
    assert np.abs(np.sum(back.rotations * truth.rotations, axis=-1)).min() > 1.0 - 1e-6
    assert back.eye_height == pytest.approx(simulated.eye_height, abs=1e-6)
    assert np.allclose(back.mounts.offsets, simulated.mounts.offsets, atol=1e-6)
    assert [empty.name for empty in empties] == ["walk head", "walk left", "walk right"]


def test_parents_constraints_and_camera_axes_count(empty, simulated) -> None:
    empties = objects.show_recording(simulated, empty)
    empty.frame_end = 60
    plain = objects.recording_from_objects(empty, empties)
    room = bpy.data.objects.new("Room", None)
    empty.collection.objects.link(room)
    room.location, room.rotation_euler = (1.0, 2.0, 0.0), (0.0, 0.0, 0.5)
    cameras = []
    for tracker in empties:
        tracker.parent = room
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        empty.collection.objects.link(camera)
        # a camera at the tracker that looks along its forward axis with its up
        camera.parent = tracker
        camera.matrix_parent_inverse = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
        cameras.append(camera)
    moved = objects.recording_from_objects(empty, cameras, axes="CAMERA", eye_height=plain.eye_height)
    turn = quat.from_yaw(0.5)
    expected = quat.rotate(turn, plain.positions) + np.array([1.0, 2.0, 0.0])
    assert np.abs(moved.positions - expected).max() < 1e-4
    forward = quat.rotate(moved.rotations, np.array([0.0, 1.0, 0.0]))
    assert (
        np.abs(forward - quat.rotate(quat.multiply(turn, plain.rotations), np.array([0.0, 1.0, 0.0]))).max()
        < 1e-4
    )


def test_a_missing_controller_is_lost_and_a_missing_headset_refused(empty, simulated) -> None:
    head, left, _ = objects.show_recording(simulated, empty)
    empty.frame_end = 60
    back = objects.recording_from_objects(empty, (head, left, None))
    assert back.valid[:, :2].all() and not back.valid[:, 2].any() and np.isfinite(back.positions).all()
    with pytest.raises(InputError, match="headset"):
        objects.recording_from_objects(empty, (None, left, None))
    with pytest.raises(InputError, match="twice"):
        objects.recording_from_objects(empty, (head, left, left))


def hill(empty: bpy.types.Scene) -> bpy.types.Object:
    """The plane z = 0.5 x, 4 m wide, as a scaled, moved object."""
    mesh = bpy.data.meshes.new("Hill")
    mesh.from_pydata([(-1, -1, -0.5), (1, -1, 0.5), (1, 1, 0.5), (-1, 1, -0.5)], [], [(0, 1, 2, 3)])
    obj = bpy.data.objects.new("Hill", mesh)
    obj.matrix_world = Matrix.LocRotScale(Vector((0.0, 0.0, 0.0)), None, Vector((2.0, 2.0, 2.0)))
    empty.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def test_heights_and_normals_of_a_slope(empty) -> None:
    slope = hill(empty)
    random = np.random.default_rng(0)
    points = np.column_stack([random.uniform(-1.5, 1.5, (50, 2)), random.uniform(0.8, 1.2, 50)])
    heights, normals = ground.ground_heights(points, [slope])
    assert np.abs(heights - 0.5 * points[:, 0]).max() < 1e-5
    assert np.abs(normals - np.array([-0.5, 0.0, 1.0]) / np.sqrt(1.25)).max() < 1e-5


def test_a_floor_above_does_not_count_and_nothing_below_is_nan(empty) -> None:
    slope, roof = hill(empty), hill(empty)
    roof.location.z = 3.0
    bpy.context.view_layer.update()
    points = np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 3.1], [50.0, 0.0, 0.0]])
    heights, normals = ground.ground_heights(points, [slope, roof])
    assert heights[:2] == pytest.approx([0.0, 3.0], abs=1e-5) and np.isnan(heights[2])
    assert normals[2].tolist() == [0.0, 0.0, 1.0]


def test_modifiers_count_and_other_objects_do_not(empty) -> None:
    slope = hill(empty)
    lifted = slope.modifiers.new("Lift", "DISPLACE")
    lifted.direction, lifted.strength, lifted.mid_level = "Z", 0.25, 0.0
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))
    empty.collection.objects.link(light)
    bpy.context.view_layer.update()
    heights, _ = ground.ground_heights(np.array([[0.0, 0.0, 0.5]]), [light, slope])
    assert heights == pytest.approx([0.5], abs=1e-5)
    assert np.isnan(ground.ground_heights(np.zeros((1, 3)), [light])[0]).all()
