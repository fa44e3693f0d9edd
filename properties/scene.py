"""What a scene remembers of Footwork."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..bridge.ground import SURFACES
from ..core.bounds import EYE_HEIGHT
from ..core.methods import TRAVELS
from .file_path import file_path
from .reading import FOOTWORK_PG_reading
from .rows import STATES, FOOTWORK_PG_database, FOOTWORK_PG_figure, FOOTWORK_PG_take
from .settings_groups import (
    FOOTWORK_PG_bake_settings,
    FOOTWORK_PG_database_settings,
    FOOTWORK_PG_train_settings,
)
from .version import Versioned

NAME = "footwork"
"""Property of a scene that holds all of it."""
OVERLAYS_NAME = "overlays"
"""Property of the scene's group that holds the overlays' toggles; the panels make it from their registry."""


def is_armature(self: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Only armatures may be picked as rig."""
    return obj.type == "ARMATURE"


def has_surface(self: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Only objects with a surface may be picked as ground."""
    return obj.type in SURFACES


def forget_recording(self: "FOOTWORK_PG_scene", context: bpy.types.Context) -> None:
    """What was found belongs to the file that was read."""
    self.recording_state = "NEW"
    self.recording_found = self.recording_doubts = ""


def tracker(label: str):
    """A property for one of the three tracked objects."""
    return PointerProperty(
        name=label, description=f"Object that moved with the {label.lower()}", type=bpy.types.Object
    )


class FOOTWORK_PG_scene(Versioned, bpy.types.PropertyGroup):
    """Everything that the Footwork panels show of a scene."""

    takes: CollectionProperty(type=FOOTWORK_PG_take, name="Takes", description="Motion-capture files")
    take_index: IntProperty(name="Active Take", description="The take that is shown below the list")
    database_settings: PointerProperty(type=FOOTWORK_PG_database_settings)
    database_path: file_path(
        "Save As", "Where the motion database is written; empty for a name beside the .blend file"
    )
    database_skeleton: file_path(
        "Skeleton Of",
        "Database whose skeleton this one shall have, so that a bake can use both; empty for the first take's own",
    )
    database_tags: StringProperty(
        name="Tags", description="Words to find the database by, separated by commas"
    )

    databases: CollectionProperty(
        type=FOOTWORK_PG_database,
        name="Databases",
        description="Motion databases of the bake; the first one that fits the headset's height is used",
    )
    database_index: IntProperty(
        name="Active Database", description="The database that is shown below the list"
    )

    predictor: EnumProperty(
        name="Body Orientation",
        description="Where the direction of the body comes from, which a headset does not measure",
        items=[
            ("SHIPPED", "Built-in", "The predictor that comes with Footwork"),
            ("FILE", "From File", "A predictor that was trained on your own takes"),
            ("HEADSET", "Headset", "The body always faces where the headset looks: only for comparison"),
        ],
    )
    predictor_path: file_path("Predictor", "Predictor that was trained on your own takes")

    train_settings: PointerProperty(type=FOOTWORK_PG_train_settings)
    train_path: file_path(
        "Save As", "Where the predictor is written; empty for a name beside the .blend file"
    )
    trained: StringProperty(name="Last Training", description="What came of the last training")

    recording_source: EnumProperty(
        name="Source",
        description="Where the recording of headset and controllers comes from",
        items=[
            ("FILE", "File", "A recording of a headset and two controllers"),
            ("OBJECTS", "Scene Objects", "Three animated objects of the scene, over its frame range"),
        ],
    )
    recording_path: file_path(
        "Recording", "Recording of a headset and two controllers", update=forget_recording
    )
    recording_state: EnumProperty(name="State", description="What reading it gave", items=STATES)
    recording_found: StringProperty(name="Found", description="What was found in the recording, a line each")
    recording_doubts: StringProperty(name="Doubts", description="What should be looked at, a line each")
    recording_from: FloatProperty(
        name="From",
        description="Bake the recording from this time on",
        unit="TIME_ABSOLUTE",
        min=0.0,
        step=10,
        precision=4,
    )
    recording_to: FloatProperty(
        name="To",
        description="Bake the recording up to this time; 0 for its end",
        unit="TIME_ABSOLUTE",
        min=0.0,
        step=10,
        precision=4,
    )
    reading: PointerProperty(type=FOOTWORK_PG_reading)
    use_eye_height: BoolProperty(
        name="Eye Height",
        description="Give the eye height by hand instead of finding it in the recording",
    )
    eye_height: FloatProperty(
        name="Eye Height",
        description="Height of the headset when its wearer stands upright",
        subtype="DISTANCE",
        min=EYE_HEIGHT[0],
        max=EYE_HEIGHT[1],
        default=1.65,
        step=1,
        precision=3,
    )
    head: tracker("Headset")
    left: tracker("Left Controller")
    right: tracker("Right Controller")
    tracker_axes: EnumProperty(
        name="Axes",
        description="Which way the objects point",
        items=[
            ("Y_FORWARD", "Y Forward, Z Up", "As Footwork's own tracker empties"),
            ("CAMERA", "-Z Forward, Y Up", "As cameras, OpenXR devices and Blender's VR objects"),
        ],
    )

    rig: PointerProperty(
        name="Rig",
        description="Armature to animate; empty to make a mannequin as tall as the user",
        type=bpy.types.Object,
        poll=is_armature,
    )
    ground: PointerProperty(
        name="Ground",
        description="Mesh that the feet stand on, as it is at the current frame; its highest surface counts, so no "
        "roof may be part of it. Empty for the recording's level floor",
        type=bpy.types.Object,
        poll=has_surface,
    )
    ground_collection: PointerProperty(
        name="Ground Collection",
        description="Meshes that the feet stand on, such as terrain, kerbs and stairs, as they are at the current "
        "frame; the highest surface counts, so no roof may be part of it. The rig and its clothes may be",
        type=bpy.types.Collection,
    )
    bake: PointerProperty(type=FOOTWORK_PG_bake_settings)
    place: EnumProperty(
        name="Place",
        description="Where in the scene the bake is",
        items=[
            ("RECORDING", "Recording", "In the recording's own world, wherever the rig stands"),
            ("RIG", "Rig", "It starts where the rig stands, facing as the rig faces"),
            ("MARKER", "Marker", "It starts at an object and faces along the object's Y axis"),
        ],
    )
    place_marker: PointerProperty(
        name="Marker",
        description="Object at which the bake starts, as it is at the current frame: its place is the floor there, "
        "its Y axis the way that the body faces",
        type=bpy.types.Object,
    )
    travel: EnumProperty(
        name="Travel",
        description="What carries the way over the ground, as game engines ask for it",
        items=[(name, name.replace("-", " ").title(), text) for name, text in TRAVELS.items()],
    )
    write: EnumProperty(
        name="Write",
        description="What becomes of the rig's present animation",
        items=[
            ("NEW", "New Action", "The bake is a new action; the present one is kept"),
            ("RANGE", "Into the Action", "A copy of the present action has the bake in the bake's frames"),
            ("STRIP", "NLA Strip", "The bake is a strip on top, with the present action as a strip below it"),
        ],
    )
    blend: IntProperty(
        name="Blend",
        description="Frames over which the bake fades in and out of what it is written into or lies on",
        default=0,
        min=0,
        soft_max=60,
    )
    fewer_keys: FloatProperty(
        name="Fewer Keys (mm)",
        description="Leave out keys without which no joint is farther than this from where all keys have it, so that "
        "curves can be edited; 0 for all keys",
        default=0.0,
        min=0.0,
        max=100.0,
        soft_max=10.0,
        step=10,
        precision=2,
    )
    action_name: StringProperty(
        name="Action", description="Name of the new action; empty for the recording's name"
    )
    frame_start: IntProperty(name="Start Frame", description="Frame of the first key", default=1)
    keep_previous: BoolProperty(
        name="Keep Previous Bakes",
        description="Keep the action of the last bake with a fake user instead of replacing it",
        default=True,
    )
    markers: BoolProperty(
        name="Transition Markers",
        description="Set a pose marker wherever the motion changes its place in the databases",
        default=True,
    )
    mannequin: BoolProperty(
        name="Mannequin",
        description="Give the armature that a bake without a rig makes a body; off for bones alone",
        default=True,
    )
    fit_range: BoolProperty(
        name="Fit Scene Range", description="Set the scene's frame range to the bake", default=True
    )

    figures: CollectionProperty(
        type=FOOTWORK_PG_figure, name="Quality", description="Figures of the last bake"
    )
    figures_of: StringProperty(name="Last Bake", description="What the figures belong to")
    over_time: StringProperty(name="Figures over Time", description="The figures of the last bake as JSON")
    warnings: StringProperty(name="Warnings", description="Warnings of the last bake, a line each")


def footwork_of(scene: bpy.types.Scene) -> FOOTWORK_PG_scene:
    """Everything that a scene remembers of Footwork."""
    return getattr(scene, NAME)


CLASSES = (FOOTWORK_PG_scene,)
