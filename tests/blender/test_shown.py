"""Joint poses read back from Blender's evaluation."""

from __future__ import annotations

import bpy
import helpers
import numpy as np
from footwork.bridge import action, armature
from footwork.bridge.shown import joint_poses
from footwork.core.evaluation.evaluate import agreement
from footwork.core.measure.subject import Body, body_of
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.keys import to_bone_tracks
from mathutils import Euler, Matrix


def test_what_blender_shows_is_within_a_millimetre_and_a_tenth_of_a_degree(empty) -> None:
    """On an object that is turned, moved and in centimetres, as FBX files have it."""
    obj = armature.create_armature(
        rig_from_skeleton(helpers.skeleton(), "Person"), "Person", empty.collection
    )
    obj.data.transform(Matrix.Scale(100.0, 4))
    obj.data.transform(Matrix.Rotation(-np.pi / 2, 4, "X"))
    obj.matrix_world = Matrix.LocRotScale((0.3, -0.2, 0.0), Euler((np.pi / 2, 0.0, 0.7)), (0.01,) * 3)
    bpy.context.view_layer.update()
    fit = fit_rig(armature.armature_to_rig(obj))
    truth = helpers.motion(fit.skeleton)
    action.write_action(
        obj, to_bone_tracks(truth, fit, 60.0), "Walk", fps=60.0, frame_start=empty.frame_start
    )
    body = body_of(truth)
    shown = Body(body.skeleton, body.fps, *joint_poses(obj, empty, len(truth)))
    apart = agreement(shown, body)
    assert apart["position_mm"] < 1.0 and apart["rotation_deg"] < 0.1
    # and it tells where they are not the same
    obj.pose.bones["LeftKnee"].constraints.new("LIMIT_ROTATION").use_limit_x = True
    broken = Body(body.skeleton, body.fps, *joint_poses(obj, empty, len(truth)))
    assert agreement(broken, body)["rotation_deg"] > 5.0
