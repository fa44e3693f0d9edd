"""What a scene remembers of Footwork, and the role map of an armature."""

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

from ..bridge import armature
from ..bridge.ground import SURFACES
from ..core.body.skeleton import ROLES
from ..core.settings import BakeSettings, DatabaseSettings
from ..nn.settings import TrainSettings
from .from_settings import property_group

# From 4.5 on Blender wants to be told that "//" paths are understood
PATH_OPTIONS = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()

STATES = [
    ("NEW", "Not read", "Not read yet", "QUESTION", 0),
    ("OK", "Good", "Read, nothing doubtful", "CHECKMARK", 1),
    ("DOUBT", "Doubtful", "Read, but something should be looked at", "ERROR", 2),
    ("FAULT", "Unusable", "Cannot be used", "CANCEL", 3),
]

FOOTWORK_PG_database_settings = property_group("FOOTWORK_PG_database_settings", DatabaseSettings)
FOOTWORK_PG_train_settings = property_group("FOOTWORK_PG_train_settings", TrainSettings)
FOOTWORK_PG_bake_settings = property_group("FOOTWORK_PG_bake_settings", BakeSettings)


def file_path(label: str, text: str, **options: object):
    """A property for a file that may be relative to the .blend."""
    return StringProperty(
        name=label, description=text, subtype="FILE_PATH", options=PATH_OPTIONS | {"ANIMATABLE"}, **options
    )


class Row:
    """A file in a list, and what was found in it."""

    path: file_path("File", "The file")
    use: BoolProperty(name="Use", description="Take part in the next step", default=True)
    state: EnumProperty(name="State", description="What reading it gave", items=STATES)
    seconds: FloatProperty(name="Length", description="Length in seconds", unit="TIME_ABSOLUTE")
    found: StringProperty(name="Found", description="What was found in the file, a line each")
    doubts: StringProperty(name="Doubts", description="What should be looked at, a line each")


class FOOTWORK_PG_take(Row, bpy.types.PropertyGroup):
    """A take in the list."""

    leave_out: StringProperty(
        name="Leave Out",
        description='Seconds that stay out of the database, such as "0-1.5, 30-32"; "90-" is up to the end',
    )
    contacts: StringProperty(
        name="Contacts",
        description="Seconds in which a foot is planted or lifted, whatever is detected, such as "
        '"L:planted:1.2-1.65, R:lifted:3-3.4"',
    )


class FOOTWORK_PG_database(Row, bpy.types.PropertyGroup):
    """A motion database in the list."""

    height_low: FloatProperty(
        name="From",
        description="Used from this headset height on, as a share of the standing eye height",
        min=0.0,
        max=2.0,
        default=0.0,
        step=1,
    )
    height_high: FloatProperty(
        name="To",
        description="Used below this headset height, as a share of the standing eye height",
        min=0.0,
        max=2.0,
        default=2.0,
        step=1,
    )


class FOOTWORK_PG_figure(bpy.types.PropertyGroup):
    """One line of the Quality panel."""

    value: StringProperty(name="Value", description="Mean, with its unit")
    detail: StringProperty(name="Detail", description="Spread of the value")
    text: StringProperty(name="Meaning", description="What the figure says")
    good: EnumProperty(
        name="Rating",
        description="Whether the figure is as it should be",
        items=[
            ("NONE", "None", "Not rated"),
            ("GOOD", "Good", "As it should be"),
            ("POOR", "Poor", "Look at it"),
        ],
    )


def is_armature(self: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Only armatures may be picked as rig."""
    return obj.type == "ARMATURE"


def has_surface(self: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Only objects with a surface may be picked as ground."""
    return obj.type in SURFACES


def forget_recording(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """What was found belongs to the file that was read."""
    self.recording_state = "NEW"
    self.recording_found = self.recording_doubts = ""


def tracker(label: str):
    """A property for one of the three tracked objects."""
    return PointerProperty(
        name=label, description=f"Object that moved with the {label.lower()}", type=bpy.types.Object
    )


class FOOTWORK_PG_scene(bpy.types.PropertyGroup):
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
    use_eye_height: BoolProperty(
        name="Eye Height",
        description="Give the eye height by hand instead of finding it in the recording",
    )
    eye_height: FloatProperty(
        name="Eye Height",
        description="Height of the headset when its wearer stands upright",
        subtype="DISTANCE",
        min=0.3,
        max=3.0,
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
        description="Armature to animate; empty to make one with the database's proportions",
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
    fit_range: BoolProperty(
        name="Fit Scene Range", description="Set the scene's frame range to the bake", default=True
    )

    figures: CollectionProperty(
        type=FOOTWORK_PG_figure, name="Quality", description="Figures of the last bake"
    )
    figures_of: StringProperty(name="Last Bake", description="What the figures belong to")
    over_time: StringProperty(name="Figures over Time", description="The figures of the last bake as JSON")
    show_graph: BoolProperty(
        name="Graph in Viewport",
        description="Show body to user, body direction and foot skate over time at the foot of the viewport; "
        "the line across is the value up to which they count as good",
        default=True,
    )
    warnings: StringProperty(name="Warnings", description="Warnings of the last bake, a line each")


def attribute(role: str) -> str:
    """Name of a role's property in the role map: a dot cannot be in one."""
    return role.replace(".", "_")


def role_label(role: str) -> str:
    """A role in people's words, without its side."""
    return role.partition(".")[0].replace("_", " ").capitalize()


def _bone_property(role: str):
    def read(self: bpy.types.PropertyGroup) -> str:
        obj = self.id_data
        return armature.role_map(obj).get(role, "") if obj.type == "ARMATURE" else ""

    def write(self: bpy.types.PropertyGroup, bone: str) -> None:
        if self.id_data.type == "ARMATURE":
            armature.set_role(self.id_data, role, bone)

    side = {"L": "left ", "R": "right "}.get(role.partition(".")[2], "")
    return StringProperty(
        name=role_label(role),
        description=f"Bone that moves as the {side}{role_label(role).lower()}; empty for none",
        get=read,
        set=write,
    )


FOOTWORK_PG_role_map = type(
    "FOOTWORK_PG_role_map",
    (bpy.types.PropertyGroup,),
    {
        "__annotations__": {attribute(role): _bone_property(role) for role in ROLES},
        "__doc__": "Which bone plays which role: what was detected, until it is set by hand.",
    },
)

CLASSES = (
    FOOTWORK_PG_database_settings,
    FOOTWORK_PG_train_settings,
    FOOTWORK_PG_bake_settings,
    FOOTWORK_PG_take,
    FOOTWORK_PG_database,
    FOOTWORK_PG_figure,
    FOOTWORK_PG_scene,
    FOOTWORK_PG_role_map,
)


def register() -> None:
    """Add the properties to scenes and objects."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.footwork = PointerProperty(type=FOOTWORK_PG_scene)
    bpy.types.Object.footwork = PointerProperty(type=FOOTWORK_PG_role_map)


def unregister() -> None:
    """Take them away again; what was saved in files stays there."""
    del bpy.types.Object.footwork
    del bpy.types.Scene.footwork
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
