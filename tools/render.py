"""Pictures of an animated armature: a contact sheet and a film, by Blender's Workbench, without a screen."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

WIDTH, HEIGHT = 480, 360
FILM_FPS = 12


def stage(scene: bpy.types.Scene) -> bpy.types.Object:
    """Add a floor, bodies on the bones of armatures that have no mesh, and a camera; return the camera."""
    for armature in [obj for obj in scene.objects if obj.type == "ARMATURE"]:
        if not any(obj.type == "MESH" and obj.find_armature() == armature for obj in scene.objects):
            _flesh(scene, armature)
    _floor(scene)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 40
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.engine = "BLENDER_WORKBENCH"
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    # without a graphics card every sample counts
    scene.display.render_aa = "FXAA"
    shading = scene.display.shading
    shading.light, shading.color_type, shading.show_shadows = "STUDIO", "MATERIAL", True
    shading.shadow_intensity = 0.35
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.color = (0.55, 0.60, 0.66)
    return camera


@contextlib.contextmanager
def hushed() -> Iterator[None]:
    """While it lasts, what Blender prints for each frame is kept back; shown only if something fails."""
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile() as log:
        kept = os.dup(1), os.dup(2)
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        failed = True
        try:
            yield
            failed = False
        finally:
            for stream, number in zip(kept, (1, 2), strict=True):
                os.dup2(stream, number)
                os.close(stream)
            if failed:
                log.seek(0)
                sys.stderr.write(log.read().decode("utf-8", "replace"))


def contact_sheet(
    scene: bpy.types.Scene, camera: bpy.types.Object, frames: Sequence[int], target: Path, columns: int = 4
) -> None:
    """One PNG with the given frames in reading order."""
    scene.display.render_aa = "8"
    with tempfile.TemporaryDirectory() as folder:
        tiles = [
            _shot(scene, camera, int(frame), Path(folder) / f"{i}.png") for i, frame in enumerate(frames)
        ]
    scene.display.render_aa = "FXAA"
    blank = np.ones_like(tiles[0])
    tiles += [blank] * (-len(tiles) % columns)
    rows = [np.concatenate(tiles[i : i + columns], axis=1) for i in range(0, len(tiles), columns)]
    sheet = np.concatenate(rows[::-1], axis=0)
    image = bpy.data.images.new("sheet", sheet.shape[1], sheet.shape[0])
    image.pixels.foreach_set(sheet.ravel())
    image.filepath_raw, image.file_format = str(target.resolve()), "PNG"
    image.save()
    bpy.data.images.remove(image)


def film(scene: bpy.types.Scene, camera: bpy.types.Object, target: Path, seconds: float = 14.0) -> None:
    """An H.264 film of the scene from its start, `seconds` long at most."""
    rate = scene.render.fps / scene.render.fps_base
    step = max(1, round(rate / FILM_FPS))
    last = min(scene.frame_end, scene.frame_start + round(seconds * rate))
    for frame in range(scene.frame_start, last + 1, step):
        scene.frame_set(frame)
        _aim(camera, _subject(scene))
        camera.keyframe_insert("location", frame=frame)
        camera.keyframe_insert("rotation_euler", frame=frame)
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"
    scene.render.ffmpeg.format, scene.render.ffmpeg.codec = "MPEG4", "H264"
    scene.render.ffmpeg.constant_rate_factor = "MEDIUM"
    scene.render.fps, scene.render.fps_base = max(1, round(rate / step)), 1.0
    scene.frame_step, scene.frame_end = step, last
    scene.render.filepath, scene.render.use_file_extension = str(target.resolve()), False
    bpy.ops.render.render(animation=True)


def _shot(scene: bpy.types.Scene, camera: bpy.types.Object, frame: int, path: Path) -> np.ndarray:
    scene.frame_set(frame)
    _aim(camera, _subject(scene))
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format = "PNG"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(HEIGHT, WIDTH, -1)


def _subject(scene: bpy.types.Scene) -> Vector:
    """Middle of the first armature's bones in the world."""
    armature = next(obj for obj in scene.objects if obj.type == "ARMATURE")
    heads = [armature.matrix_world @ bone.head for bone in armature.pose.bones]
    return sum(heads, Vector()) / len(heads)


def _aim(camera: bpy.types.Object, subject: Vector) -> None:
    centre = Vector((subject.x, subject.y, 0.85))
    camera.location = centre + Vector((1.9, -2.7, 0.6))
    camera.rotation_euler = (centre - camera.location).to_track_quat("-Z", "Y").to_euler()


def _flesh(scene: bpy.types.Scene, armature: bpy.types.Object) -> None:
    """A rounded box on every bone, parented to it, so that a bare armature shows in renders."""
    for bone in armature.data.bones:
        half = 0.5 * bone.length
        width, depth = _girth(bone.name)
        ends = (-1.1 * half, 1.1 * half)  # overlapping, so that no joint gapes
        corners = [(x, y, z) for y in ends for x in (-width, width) for z in (-depth, depth)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6)]
        mesh = bpy.data.meshes.new(bone.name)
        mesh.from_pydata(corners, [], faces)
        mesh.shade_smooth()
        body = bpy.data.objects.new(bone.name, mesh)
        scene.collection.objects.link(body)
        body.parent, body.parent_type, body.parent_bone = armature, "BONE", bone.name
        body.location = (0.0, -half, 0.0)
        _paint(mesh, _colour(bone.name))
        rounding = body.modifiers.new("Rounding", "BEVEL")
        rounding.width, rounding.segments = 0.8 * min(width, depth, half), 4


def _girth(name: str) -> tuple[float, float]:
    """Half the width and depth of a body part, metres."""
    lowered = name.lower()
    sizes = {"collar": (0.03, 0.03), "wrist": (0.045, 0.02), "hand": (0.045, 0.02), "toe": (0.045, 0.02)}
    sizes |= {"ankle": (0.045, 0.025), "foot": (0.045, 0.025), "hip": (0.07, 0.07), "knee": (0.05, 0.05)}
    sizes |= {"left": (0.04, 0.04), "right": (0.04, 0.04), "head": (0.075, 0.09), "neck": (0.045, 0.045)}
    if lowered == "hips":
        return 0.14, 0.09
    return next((size for part, size in sizes.items() if part in lowered), (0.13, 0.08))


def _colour(name: str) -> tuple[float, float, float, float]:
    """Left warm, right cold, centre light: a twisted limb shows at once."""
    lowered = name.lower()
    if "left" in lowered or lowered.endswith((".l", "_l")):
        return (0.85, 0.35, 0.20, 1.0)
    if "right" in lowered or lowered.endswith((".r", "_r")):
        return (0.20, 0.45, 0.85, 1.0)
    return (0.75, 0.75, 0.72, 1.0)


def _paint(mesh: bpy.types.Mesh, colour: tuple[float, float, float, float]) -> None:
    material = bpy.data.materials.new(mesh.name)
    material.diffuse_color = colour
    mesh.materials.append(material)


def _floor(scene: bpy.types.Scene) -> None:
    """A chequered floor of one-metre tiles."""
    for shade, odd in ((0.50, 0), (0.60, 1)):
        tiles = [(x, y) for x in range(-12, 12) for y in range(-12, 12) if (x + y) % 2 == odd]
        corners = [(x + dx, y + dy, 0.0) for x, y in tiles for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))]
        mesh = bpy.data.meshes.new("Floor")
        mesh.from_pydata(corners, [], [tuple(range(4 * i, 4 * i + 4)) for i in range(len(tiles))])
        floor = bpy.data.objects.new("Floor", mesh)
        _paint(mesh, (shade, shade, shade, 1.0))
        scene.collection.objects.link(floor)
