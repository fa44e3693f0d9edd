"""Every panel draws, in every state of the scene, with properties, operators and icons that exist."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace

import bpy
import helpers
import pytest
from footwork import panels
from footwork.bridge import armature
from footwork.bridge.settings import read_settings
from footwork.core.rig.fit import rig_from_skeleton
from footwork.core.settings import BAKE_PRESETS, BakeSettings, DatabaseSettings, check
from footwork.nn.settings import TrainSettings
from footwork.operators import job_operator, training
from footwork.panels import lists, preferences
from footwork.properties.preferences import ADD_ON

ICONS = {
    item.identifier for item in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
}
PANELS = [cls for cls in panels.CLASSES if "_PT_" in cls.__name__ and "presets" not in cls.bl_idname]


class Layout(SimpleNamespace):
    """Stands for a layout: checks what is asked of it and keeps the texts."""

    def __init__(self, texts: list[str], properties: list[str]) -> None:
        super().__init__(texts=texts, properties=properties)

    def _sub(self, **_options: object) -> Layout:
        return Layout(self.texts, self.properties)

    row = column = split = box = grid_flow = _sub

    def separator(self, **_options: object) -> None: ...

    def label(self, *, text: str = "", icon: str = "NONE") -> None:
        assert icon in ICONS, icon
        self.texts.append(text)

    def panel(self, name: str, default_closed: bool = False) -> tuple[Layout, Layout]:
        return self._sub(), self._sub()

    def prop(self, data, name: str, *, text: str = "", icon: str = "NONE", **_options: object) -> None:
        assert icon in ICONS, icon
        prop = data.bl_rna.properties[name]
        assert prop.description and not prop.description.endswith("."), f"{name} has no tooltip"
        getattr(data, name)
        self.texts.append(text or prop.name)
        self.properties.append(name)

    def prop_search(self, data, name: str, where, collection: str, **_options: object) -> None:
        getattr(where, collection)
        self.prop(data, name)

    def operator(self, idname: str, *, text: str = "", icon: str = "NONE", **_options: object):
        assert icon in ICONS, icon
        module, name = idname.split(".")
        rna = getattr(getattr(bpy.ops, module), name).get_rna_type()
        assert rna.description, f"{idname} has no tooltip"
        self.texts.append(text or rna.name)
        return SimpleNamespace()

    def menu(self, idname: str, **_options: object) -> None:
        assert hasattr(bpy.types, idname)

    def template_list(
        self, kind: str, _id: str, data, collection: str, active, index: str, **_options: object
    ) -> None:
        getattr(active, index)
        for row in getattr(data, collection):
            getattr(bpy.types, kind).draw_item(None, bpy.context, self, data, row, 0, active, index)

    def popover(self, *, panel: str, **_options: object) -> None:
        assert hasattr(bpy.types, panel)

    def progress(self, *, factor: float, text: str) -> None:
        self.texts.append(text)


def draw(cls: type) -> Layout:
    """What a panel shows."""
    panel = SimpleNamespace(layout=Layout([], []))
    for helper in ("step_icon", "_advanced"):
        if hasattr(cls, helper):
            setattr(panel, helper, getattr(cls, helper).__get__(panel))
    if hasattr(cls, "draw_header_preset"):
        cls.draw_header_preset(panel, bpy.context)
    cls.draw(panel, bpy.context)
    return panel.layout


@pytest.fixture
def filled(empty):
    """A scene in the middle of the work."""
    footwork = empty.footwork
    for name, state in (("walk", "OK"), ("turn", "DOUBT"), ("broken", "FAULT"), ("new", "NEW")):
        take = footwork.takes.add()
        take.name, take.state, take.path = name, state, f"/{name}.bvh"
        take.seconds, take.found, take.doubts = 61.0, "unit\tcm\nup\tY", "something to look at" * 5
    database = footwork.databases.add()
    database.name, database.found = "walking", "clips\t3"
    footwork.recording_path, footwork.recording_found = "/r.csv", "format\tours"
    footwork.recording_doubts = "left controller lost"
    footwork.rig = armature.create_armature(
        rig_from_skeleton(helpers.skeleton(), "Person"), "Person", empty.collection
    )
    figure = footwork.figures.add()
    figure.name, figure.value, figure.good = "Hands", "0.1 cm", "GOOD"
    footwork.trained = "6.5° mean error"
    footwork.over_time = '{"series": {}}'
    return footwork


@pytest.mark.parametrize("cls", PANELS, ids=lambda cls: cls.bl_idname)
def test_panels_draw_in_an_empty_scene(empty, cls) -> None:
    draw(cls)


@pytest.mark.parametrize("cls", PANELS, ids=lambda cls: cls.bl_idname)
def test_panels_draw_in_the_middle_of_the_work(filled, cls) -> None:
    for source in ("FILE", "OBJECTS"):
        filled.recording_source = source
        for predictor in ("SHIPPED", "FILE", "HEADSET"):
            filled.predictor = predictor
            for trajectory in ("causal", "look-ahead"):
                filled.bake.trajectory = trajectory
                draw(cls)


def test_panels_draw_for_a_rig_that_is_not_understood(filled) -> None:
    bpy.context.view_layer.objects.active = filled.rig
    bpy.ops.object.mode_set(mode="EDIT")
    bones = filled.rig.data.edit_bones
    for name in ("LeftHip", "RightHip"):
        for bone in [*bones[name].children_recursive, bones[name]]:
            bones.remove(bone)
    bpy.ops.object.mode_set(mode="OBJECT")
    for number, bone in enumerate(filled.rig.data.bones):
        bone.name = f"x{number}"
    texts = " ".join(draw(panels.rig.FOOTWORK_PT_rig).texts)
    assert "not recognised" in texts and "Set bones below" in texts


@pytest.mark.parametrize(
    ("cls", "operator"),
    [
        (panels.takes.FOOTWORK_PT_takes, "footwork.inspect_takes"),
        (panels.takes.FOOTWORK_PT_takes, "footwork.build_database"),
        (panels.predictor.FOOTWORK_PT_predictor, "footwork.train_predictor"),
        (panels.bake.FOOTWORK_PT_bake, "footwork.bake"),
    ],
)
def test_the_running_job_is_shown_where_it_was_started(filled, monkeypatch, cls, operator) -> None:
    monkeypatch.setattr(job_operator, "running", job_operator.Running(operator, "Busy", 0.25, "halfway soon"))
    texts = draw(cls).texts
    assert "Busy: 25%" in texts and "halfway soon" in texts


def test_the_preferences_say_whether_training_is_possible(empty, monkeypatch) -> None:
    for missing, says in (("", "Training is possible"), ("get PyTorch", "get PyTorch")):
        monkeypatch.setattr(
            training, "find_trainer", lambda context, missing=missing: training.Trainer("python", missing)
        )
        stored = bpy.context.preferences.addons[ADD_ON].preferences
        page = SimpleNamespace(layout=Layout([], []), bl_rna=stored.bl_rna, training_python="")
        preferences.FOOTWORK_preferences.draw(page, bpy.context)
        assert says in page.layout.texts


def test_steps_are_in_the_order_of_work() -> None:
    labels = [cls.bl_label for cls in PANELS if cls.bl_label[0].isdigit()]
    assert [label[0] for label in labels] == list("1234567")


def test_every_setting_is_shown_once(filled) -> None:
    filled.bake.trajectory = "causal"
    shown = draw(panels.bake.FOOTWORK_PT_bake).properties
    for item in fields(BakeSettings):
        assert shown.count(item.name) == 1, item.name


@pytest.mark.parametrize(
    ("group", "settings"),
    [("bake", BakeSettings), ("database_settings", DatabaseSettings), ("train_settings", TrainSettings)],
)
def test_properties_are_the_settings(empty, group: str, settings: type) -> None:
    properties = getattr(empty.footwork, group)
    assert read_settings(properties, settings) == settings()
    for item in fields(settings):
        rna, meta = properties.bl_rna.properties[item.name], item.metadata
        assert (rna.name, rna.description) == (meta["label"], meta["help"])
        for end in ("low", "high"):
            if meta[end] is not None and not isinstance(item.default, (bool, str)):
                setattr(properties, item.name, type(item.default)(meta[end]))
                value = getattr(read_settings(properties, settings), item.name)
                assert value == pytest.approx(meta[end], rel=1e-6)
                properties.property_unset(item.name)
        if meta["choices"]:
            assert [choice.identifier for choice in rna.enum_items] == list(meta["choices"])
    check(read_settings(properties, settings))


def test_presets_set_every_bake_setting(empty) -> None:
    settings = empty.footwork.bake
    found = [Path(folder) for folder in bpy.utils.preset_paths("footwork/bake")]
    shipped = [path for folder in found for path in sorted(folder.glob("*.py"))]
    assert {path.stem.replace("_", " ") for path in shipped} == set(BAKE_PRESETS)
    for path in shipped:
        settings.unlock_distance, settings.alpha = 0.77, 0.77
        bpy.ops.script.execute_preset(filepath=str(path), menu_idname="FOOTWORK_PT_bake_presets")
        made = read_settings(settings, BakeSettings)
        assert made == BakeSettings(**BAKE_PRESETS[path.stem.replace("_", " ")])


def test_own_presets_are_kept(empty) -> None:
    settings = empty.footwork.bake
    settings.alpha = 0.66
    bpy.ops.footwork.add_bake_preset(name="My Own")
    folder = Path(bpy.utils.user_resource("SCRIPTS", path="presets/footwork/bake"))
    settings.alpha = 0.2
    bpy.ops.script.execute_preset(filepath=str(folder / "My_Own.py"), menu_idname="FOOTWORK_PT_bake_presets")
    assert settings.alpha == pytest.approx(0.66)


def test_numbers_come_back_as_typed(empty) -> None:
    empty.footwork.bake.alpha = 0.35
    assert read_settings(empty.footwork.bake, BakeSettings).alpha == 0.35


def test_durations() -> None:
    assert lists.duration(0) == "0:00" and lists.duration(125.4) == "2:05"
