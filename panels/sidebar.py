"""The Footwork tab of the 3D viewport's sidebar, in the order of work."""

import bpy

from ..bridge import armature
from ..core.mocap.skeleton import ARM, CENTRE_ROLES, LEG, REQUIRED_ROLES
from ..operators import job_operator
from ..operators.databases import database_path
from ..operators.files import active
from ..operators.predictor import torch_missing
from . import text
from .lists import duration
from .properties import attribute, role_label

MAIN_BAKE_SETTINGS = ("trajectory", "search", "alpha", "beta")
CAUSAL_SETTINGS = ("beta", "smoothing")
"""Settings that only the causal trajectory uses."""
FITTING_SETTINGS = ("scale_to_rig", "foot_lock", "head", "arms")


class Part:
    """What all parts of the tab share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Footwork"

    def draw_header_preset(self, context):
        """Say at the right of the header how far this step is."""
        icon = self.step_icon(context.scene.footwork)
        if icon:
            self.layout.label(text="", icon=icon)

    def step_icon(self, footwork) -> str:
        """Icon for the step's state, "" for none."""
        return ""


def job_button(layout, operator: str, icon: str, scale: float) -> None:
    """The button that starts a job; while the job runs, its progress and a button to cancel it."""
    if not job_progress(layout, operator):
        row = layout.row()
        row.scale_y = scale
        row.operator(operator, icon=icon)


def job_progress(layout, operator: str) -> bool:
    """How far this operator's job is; False where it does not run."""
    running = job_operator.running
    if running is None or running.operator != operator:
        return False
    row = layout.row(align=True)
    row.progress(factor=running.fraction, text=f"{running.title}: {running.fraction:.0%}")
    row.operator("footwork.cancel_job", text="", icon="X")
    message = layout.row()
    message.active = False
    message.label(text=running.message)
    return True


class FOOTWORK_PT_takes(Part, bpy.types.Panel):
    """Motion-capture files, and the database that is built from them"""

    bl_idname = "FOOTWORK_PT_takes"
    bl_label = "1  Takes"

    def draw_header_preset(self, context):
        takes = [take for take in context.scene.footwork.takes if take.use]
        if takes:
            self.layout.label(text=duration(sum(take.seconds for take in takes)))

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        row = layout.row()
        row.template_list(
            "FOOTWORK_UL_takes",
            "",
            footwork,
            "takes",
            footwork,
            "take_index",
            rows=5 if footwork.takes else 3,
        )
        buttons = row.column(align=True)
        buttons.operator("footwork.add_takes", text="", icon="ADD")
        buttons.operator("footwork.remove_take", text="", icon="REMOVE")
        if footwork.takes:
            buttons.separator()
            buttons.operator("footwork.move_take", text="", icon="TRIA_UP").step = -1
            buttons.operator("footwork.move_take", text="", icon="TRIA_DOWN").step = 1
            buttons.separator()
            buttons.menu("FOOTWORK_MT_takes", text="", icon="DOWNARROW_HLT")
        job_progress(layout, "footwork.inspect_takes")
        take = active(footwork.takes, footwork.take_index)
        if take is None:
            text.notes(
                context, layout, "Add motion-capture files (.bvh), or drop them into the viewport", "INFO"
            )
            return
        found, body = layout.panel("FOOTWORK_take_found", default_closed=True)
        found.label(text="In This Take")
        if body:
            text.facts(body, take.found)
        text.notes(context, layout, take.doubts, "CANCEL" if take.state == "FAULT" else "ERROR")

        settings = footwork.database_settings
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        column.prop(settings, "mirror")
        heights = column.row(align=True)
        heights.prop(settings, "height_low", text="Height Range")
        heights.prop(settings, "height_high", text="")
        column.prop(footwork, "database_path", placeholder=database_path(footwork).name)
        self._advanced(layout, footwork)
        job_button(layout, "footwork.build_database", "FILE_NEW", 1.3)

    def _advanced(self, layout, footwork):
        header, body = layout.panel("FOOTWORK_database_advanced", default_closed=True)
        header.label(text="Advanced")
        if not body:
            return
        body.use_property_split = True
        body.use_property_decorate = False
        settings = footwork.database_settings
        for name in settings.__annotations__:
            if name not in ("mirror", "height_low", "height_high"):
                body.prop(settings, name)
        body.prop(footwork, "database_tags")


class FOOTWORK_MT_takes(bpy.types.Menu):
    """More for takes"""

    bl_idname = "FOOTWORK_MT_takes"
    bl_label = "Takes"

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        layout.operator("footwork.inspect_takes", text="Read All Again", icon="FILE_REFRESH").which = "ALL"
        take = active(footwork.takes, footwork.take_index)
        if take is not None:
            show = layout.operator("footwork.import_take", text="Show Take in Scene", icon="ARMATURE_DATA")
            show.filepath = bpy.path.abspath(take.path)
        layout.operator("footwork.simulate_recording", icon="TRACKER")
        layout.separator()
        layout.operator("footwork.clear_takes", icon="TRASH")


class FOOTWORK_PT_databases(Part, bpy.types.Panel):
    """Motion databases that the bake chooses from"""

    bl_idname = "FOOTWORK_PT_databases"
    bl_label = "2  Databases"

    def step_icon(self, footwork):
        return "CHECKMARK" if any(row.use for row in footwork.databases) else ""

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        row = layout.row()
        row.template_list(
            "FOOTWORK_UL_databases", "", footwork, "databases", footwork, "database_index", rows=3
        )
        buttons = row.column(align=True)
        buttons.operator("footwork.add_database", text="", icon="ADD")
        buttons.operator("footwork.remove_database", text="", icon="REMOVE")
        if len(footwork.databases) > 1:
            buttons.operator("footwork.move_database", text="", icon="TRIA_UP").step = -1
            buttons.operator("footwork.move_database", text="", icon="TRIA_DOWN").step = 1
        database = active(footwork.databases, footwork.database_index)
        if database is None:
            text.notes(context, layout, "Build one above, or add one that was built before", "INFO")
            return
        heights = layout.row(align=True)
        heights.use_property_split = True
        heights.use_property_decorate = False
        heights.prop(database, "height_low", text="Height Range")
        heights.prop(database, "height_high", text="")
        header, body = layout.panel("FOOTWORK_database_found", default_closed=True)
        header.label(text="In This Database")
        if body:
            text.facts(body, database.found)


class FOOTWORK_PT_predictor(Part, bpy.types.Panel):
    """Where the body's direction comes from"""

    bl_idname = "FOOTWORK_PT_predictor"
    bl_label = "3  Predictor"
    bl_options = {"DEFAULT_CLOSED"}

    def step_icon(self, footwork):
        missing = footwork.predictor == "FILE" and not footwork.predictor_path
        return "" if missing else "CHECKMARK"

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(footwork, "predictor")
        if footwork.predictor == "FILE":
            layout.prop(footwork, "predictor_path", text="File")
        header, body = layout.panel("FOOTWORK_training", default_closed=True)
        header.label(text="Training")
        if not body:
            return
        if torch_missing():
            text.notes(context, body, torch_missing(), "INFO")
        body.use_property_split = False
        settings = footwork.train_settings
        paper = settings.kind == "paper"
        unused = "voters" if paper else "iterations"
        _settings(body, settings, [name for name in settings.__annotations__ if name != unused])
        job_button(body, "footwork.train_predictor", "PLAY", 1.3)


class FOOTWORK_PT_recording(Part, bpy.types.Panel):
    """Headset and controllers over time"""

    bl_idname = "FOOTWORK_PT_recording"
    bl_label = "4  Recording"

    def step_icon(self, footwork):
        if footwork.recording_source == "OBJECTS":
            return "CHECKMARK" if footwork.head else ""
        return "CHECKMARK" if footwork.recording_path and footwork.recording_state != "FAULT" else ""

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        layout.row().prop(footwork, "recording_source", expand=True)
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        if footwork.recording_source == "OBJECTS":
            for name in ("head", "left", "right"):
                column.prop(footwork, name)
            column.prop(footwork, "tracker_axes")
            _eye_height(column, footwork)
            return
        if not footwork.recording_path:
            column.operator("footwork.load_recording", icon="FILEBROWSER")
            return
        row = column.row(align=True)
        row.prop(footwork, "recording_path", text="")
        row.operator("footwork.inspect_recording", text="", icon="FILE_REFRESH")
        _eye_height(column, footwork)
        header, body = layout.panel("FOOTWORK_recording_found", default_closed=True)
        header.label(text="In This Recording")
        if body:
            text.facts(body, footwork.recording_found)
        text.notes(
            context,
            layout,
            footwork.recording_doubts,
            "CANCEL" if footwork.recording_state == "FAULT" else "ERROR",
        )
        layout.operator("footwork.show_recording", icon="EMPTY_ARROWS")


def _eye_height(layout, footwork) -> None:
    """Given by hand, or greyed what the recording says."""
    row = layout.row(heading="Eye Height", align=True)
    row.prop(footwork, "use_eye_height", text="")
    value = row.row(align=True)
    value.active = footwork.use_eye_height
    value.prop(footwork, "eye_height", text="")


class FOOTWORK_PT_rig(Part, bpy.types.Panel):
    """The character that is animated"""

    bl_idname = "FOOTWORK_PT_rig"
    bl_label = "5  Rig"

    def step_icon(self, footwork):
        rig = footwork.rig
        if rig is None or rig.type != "ARMATURE":
            return "" if rig is None else "ERROR"
        mapped = armature.role_map(rig)
        return "CHECKMARK" if all(mapped.get(role) for role in REQUIRED_ROLES) else "ERROR"

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        row = layout.row(align=True)
        row.prop(footwork, "rig", text="")
        row.operator("footwork.use_active_rig", text="", icon="RESTRICT_SELECT_OFF")
        rig = footwork.rig
        if rig is None:
            text.notes(context, layout, "Empty: an armature with the database's proportions is made", "INFO")
            return
        preset, _ = armature.detected_preset(rig)
        layout.label(
            text=f"Bone names: {preset}" if preset else "Bone names: not recognised", icon="BONE_DATA"
        )
        missing = [role for role in REQUIRED_ROLES if not armature.role_map(rig).get(role)]
        if missing:
            names = ", ".join(role.replace("_", " ") for role in missing[:4])
            text.notes(
                context, layout, f"Set bones below for: {names}" + (" ..." if len(missing) > 4 else "")
            )
        for doubt in armature.rig_doubts(rig):
            text.notes(context, layout, doubt)
        header, body = layout.panel("FOOTWORK_role_map", default_closed=True)
        header.label(text="Role Map")
        header.operator("footwork.reset_roles", text="", icon="LOOP_BACK", emboss=False)
        if body:
            _role_map(body, rig)


def _role_map(layout, rig):
    groups = (
        ("", CENTRE_ROLES),
        ("Left", tuple(f"{part}.L" for part in (*ARM, *LEG))),
        ("Right", tuple(f"{part}.R" for part in (*ARM, *LEG))),
    )
    for heading, roles in groups:
        column = layout.column(align=True)
        if heading:
            column.label(text=heading)
        for role in roles:
            split = column.split(factor=0.3, align=True)
            split.label(text=role_label(role))
            split.prop_search(rig.footwork, attribute(role), rig.data, "bones", text="")


def _settings(layout, settings, names) -> None:
    """Settings below each other: choices beside their name, numbers with the name inside."""
    column = layout.column(align=True)
    weights = False
    for name in names:
        if name.startswith("weight_") != weights:
            weights = not weights
            column = layout.column(align=True)
            if weights:
                column.label(text="Weights in the Search")
        if settings.bl_rna.properties[name].type == "ENUM":
            split = column.split(factor=0.35)
            split.label(text=settings.bl_rna.properties[name].name)
            split.prop(settings, name, text="")
        else:
            column.prop(settings, name)


class FOOTWORK_PT_bake(Part, bpy.types.Panel):
    """The recording becomes an action of the rig"""

    bl_idname = "FOOTWORK_PT_bake"
    bl_label = "6  Bake"

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        settings = footwork.bake
        idle = () if settings.trajectory == "causal" else CAUSAL_SETTINGS
        known = [name for name in settings.__annotations__ if name not in idle]
        layout.use_property_decorate = False
        _settings(layout, settings, [name for name in MAIN_BAKE_SETTINGS if name in known])
        grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        for name in FITTING_SETTINGS:
            if name in known:
                grid.prop(settings, name)
        header, body = layout.panel("FOOTWORK_bake_advanced", default_closed=True)
        header.label(text="Advanced")
        if body:
            _settings(body, settings, [n for n in known if n not in MAIN_BAKE_SETTINGS + FITTING_SETTINGS])
        header, body = layout.panel("FOOTWORK_bake_output", default_closed=True)
        header.label(text="Output")
        if body:
            body.use_property_split = True
            body.use_property_decorate = False
            for name in ("action_name", "frame_start", "fit_range", "markers", "keep_previous"):
                body.prop(footwork, name)
        job_button(layout, "footwork.bake", "ARMATURE_DATA", 1.6)


class FOOTWORK_PT_quality(Part, bpy.types.Panel):
    """How good the last bake is"""

    bl_idname = "FOOTWORK_PT_quality"
    bl_label = "7  Quality"

    def step_icon(self, footwork):
        if not footwork.figures:
            return ""
        return "ERROR" if any(row.good == "POOR" for row in footwork.figures) else "CHECKMARK"

    def draw(self, context):
        layout, footwork = self.layout, context.scene.footwork
        if not footwork.figures:
            layout.label(text="Nothing baked yet", icon="INFO")
            return
        layout.label(text=footwork.figures_of, icon="ACTION")
        column = layout.column(align=True)
        for index, row in enumerate(footwork.figures):
            split = column.split(factor=0.55)
            icon = {"GOOD": "CHECKMARK", "POOR": "ERROR"}.get(row.good, "BLANK1")
            split.label(text=row.name, icon=icon)
            value = split.row()
            value.alignment = "LEFT"
            value.operator("footwork.explain_figure", text=row.value, emboss=False).index = index
        told = footwork.recording_doubts.splitlines()
        fresh = [line for line in footwork.warnings.splitlines() if line not in told]
        text.notes(context, layout, "\n".join(fresh))


CLASSES = (
    FOOTWORK_MT_takes,
    FOOTWORK_PT_takes,
    FOOTWORK_PT_databases,
    FOOTWORK_PT_predictor,
    FOOTWORK_PT_recording,
    FOOTWORK_PT_rig,
    FOOTWORK_PT_bake,
    FOOTWORK_PT_quality,
)
