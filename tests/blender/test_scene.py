"""Recordings from and to scene objects."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from footwork.bridge import objects
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from mathutils import Matrix


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
    moved = objects.recording_from_objects(
        empty, cameras, axes="CAMERA", answers=Answers(eye_height=plain.eye_height)
    )
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
