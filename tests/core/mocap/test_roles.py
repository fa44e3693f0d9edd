"""Joint roles: the tables of the naming schemes, prefixes, hierarchy, and what must not match."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.body.skeleton import REQUIRED_ROLES, RIG_ROLES, ROLES
from footwork.core.errors import InputError
from footwork.core.mocap.bvh import read_bvh
from footwork.core.mocap.families import KIND, families, read_family
from footwork.core.mocap.roles import match_roles
from footwork.core.presets import SHIPPED, VARIABLE
from hypothesis import given, settings
from hypothesis import strategies as st

CENTRE = ("hips", "spine1", "spine2", "spine3", "chest", "neck", "head")
LIMBS = ("clavicle", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toe")
# hips to head ("" for none, extra joints in between have role ""), then left limbs with {s} for the side
TABLE = {
    "Xsens MVN": (
        "Pelvis L5 L3 T12 T8 Neck Head",
        "{s}Shoulder {s}UpperArm {s}ForeArm {s}Hand {s}UpperLeg {s}LowerLeg {s}Foot {s}Toe",
        "Left Right",
    ),
    "Xsens": (
        "Hips Chest Chest2 Chest3 Chest4 Neck Head",
        "{s}Collar {s}Shoulder {s}Elbow {s}Wrist {s}Hip {s}Knee {s}Ankle {s}Toe",
        "Left Right",
    ),
    "Mixamo": (
        "mixamorig:Hips mixamorig:Spine - mixamorig:Spine1 mixamorig:Spine2 mixamorig:Neck mixamorig:Head",
        "mixamorig:{s}Shoulder mixamorig:{s}Arm mixamorig:{s}ForeArm mixamorig:{s}Hand "
        "mixamorig:{s}UpLeg mixamorig:{s}Leg mixamorig:{s}Foot mixamorig:{s}ToeBase",
        "Left Right",
    ),
    "LAFAN1": (
        "Hips Spine - Spine1 Spine2 Neck Head",
        "{s}Shoulder {s}Arm {s}ForeArm {s}Hand {s}UpLeg {s}Leg {s}Foot {s}Toe",
        "Left Right",
    ),
    "CMU": (
        "Hips Spine - - Spine1 Neck1 Head",
        "{s}Shoulder {s}Arm {s}ForeArm {s}Hand {s}UpLeg {s}Leg {s}Foot {s}ToeBase",
        "Left Right",
    ),
    "Unity Humanoid": (
        "Hips Spine - Chest UpperChest Neck Head",
        "{s}Shoulder {s}UpperArm {s}LowerArm {s}Hand {s}UpperLeg {s}LowerLeg {s}Foot {s}Toes",
        "Left Right",
    ),
    "Bandai Namco": (
        "Hips Spine - - Chest Neck Head",
        "Shoulder_{s} UpperArm_{s} LowerArm_{s} Hand_{s} UpperLeg_{s} LowerLeg_{s} Foot_{s} Toes_{s}",
        "L R",
    ),
    "Daz and Poser": (
        "hip abdomen - - chest neck head",
        "{s}Collar {s}Shldr {s}ForeArm {s}Hand {s}Thigh {s}Shin {s}Foot {s}Toe",
        "l r",
    ),
    "Daz Genesis 9": (
        "hip spine1 spine2 spine3 spine4 neck1 head",
        "{s}_shoulder {s}_upperarm {s}_forearm {s}_hand {s}_thigh {s}_shin {s}_foot {s}_toes",
        "l r",
    ),
    "Character Creator": (
        "CC_Base_Hip CC_Base_Waist - CC_Base_Spine01 CC_Base_Spine02 CC_Base_NeckTwist01 CC_Base_Head",
        "CC_Base_{s}_Clavicle CC_Base_{s}_Upperarm CC_Base_{s}_Forearm CC_Base_{s}_Hand "
        "CC_Base_{s}_Thigh CC_Base_{s}_Calf CC_Base_{s}_Foot CC_Base_{s}_ToeBase",
        "L R",
    ),
    "3ds Max Biped": (
        "Bip001_Pelvis Bip001_Spine - Bip001_Spine1 Bip001_Spine2 Bip001_Neck Bip001_Head",
        "Bip001_{s}_Clavicle Bip001_{s}_UpperArm Bip001_{s}_Forearm Bip001_{s}_Hand "
        "Bip001_{s}_Thigh Bip001_{s}_Calf Bip001_{s}_Foot Bip001_{s}_Toe0",
        "L R",
    ),
    "VRoid": (
        "J_Bip_C_Hips J_Bip_C_Spine - J_Bip_C_Chest J_Bip_C_UpperChest J_Bip_C_Neck J_Bip_C_Head",
        "J_Bip_{s}_Shoulder J_Bip_{s}_UpperArm J_Bip_{s}_LowerArm J_Bip_{s}_Hand "
        "J_Bip_{s}_UpperLeg J_Bip_{s}_LowerLeg J_Bip_{s}_Foot J_Bip_{s}_ToeBase",
        "L R",
    ),
    "Rigify metarig": (
        "spine spine.001 - spine.002 spine.003 spine.004 spine.006",
        "shoulder.{s} upper_arm.{s} forearm.{s} hand.{s} thigh.{s} shin.{s} foot.{s} toe.{s}",
        "L R",
    ),
    "Unreal mannequin": (
        "pelvis spine_01 - spine_02 spine_03 neck_01 head",
        "clavicle_{s} upperarm_{s} lowerarm_{s} hand_{s} thigh_{s} calf_{s} foot_{s} ball_{s}",
        "l r",
    ),
    "SMPL": (
        "pelvis spine1 - spine2 spine3 neck head",
        "{s}_collar {s}_shoulder {s}_elbow {s}_wrist {s}_hip {s}_knee {s}_ankle {s}_foot",
        "left right",
    ),
    "CATS and VRChat": (
        "Hips Spine - - Chest Neck Head",
        "{s}_shoulder {s}_arm {s}_elbow {s}_wrist {s}_leg {s}_knee {s}_ankle {s}_toe",
        "Left Right",
    ),
    "Auto-Rig Pro": (
        "root.x spine_01.x - spine_02.x spine_03.x neck.x head.x",
        "shoulder.{s} arm_stretch.{s} forearm_stretch.{s} hand.{s} "
        "thigh_stretch.{s} leg_stretch.{s} foot.{s} toes_01.{s}",
        "l r",
    ),
    "Auto-Rig Pro FK controls": (
        "c_root_master.x c_spine_01.x - c_spine_02.x c_spine_03.x c_neck.x c_head.x",
        "c_shoulder.{s} c_arm_fk.{s} c_forearm_fk.{s} c_hand_fk.{s} "
        "c_thigh_fk.{s} c_leg_fk.{s} c_foot_fk.{s} c_toes_fk.{s}",
        "l r",
    ),
    "MikuMikuDance": (
        "センター 上半身 - - 上半身2 首 頭",
        "{s}肩 {s}腕 {s}ひじ {s}手首 {s}足 {s}ひざ {s}足首 {s}つま先",
        "左 右",
    ),
    "MikuMikuDance, English": (
        "center upper_body - - upper_body_2 neck head",
        "shoulder_{s} arm_{s} elbow_{s} wrist_{s} leg_{s} knee_{s} ankle_{s} toe_{s}",
        "L R",
    ),
    "Valve": (
        "ValveBiped.Bip01_Pelvis ValveBiped.Bip01_Spine - ValveBiped.Bip01_Spine1 ValveBiped.Bip01_Spine2 "
        "ValveBiped.Bip01_Neck1 ValveBiped.Bip01_Head1",
        "ValveBiped.Bip01_{s}_Clavicle ValveBiped.Bip01_{s}_UpperArm ValveBiped.Bip01_{s}_Forearm "
        "ValveBiped.Bip01_{s}_Hand ValveBiped.Bip01_{s}_Thigh ValveBiped.Bip01_{s}_Calf ValveBiped.Bip01_{s}_Foot "
        "ValveBiped.Bip01_{s}_Toe0",
        "L R",
    ),
    "Second Life": (
        "mPelvis mTorso - - mChest mNeck mHead",
        "mCollar{s} mShoulder{s} mElbow{s} mWrist{s} mHip{s} mKnee{s} mAnkle{s} mToe{s}",
        "Left Right",
    ),
    "SMPL add-on": (
        "m_avg_Pelvis m_avg_Spine1 - m_avg_Spine2 m_avg_Spine3 m_avg_Neck m_avg_Head",
        "m_avg_{s}_Collar m_avg_{s}_Shoulder m_avg_{s}_Elbow m_avg_{s}_Wrist "
        "m_avg_{s}_Hip m_avg_{s}_Knee m_avg_{s}_Ankle m_avg_{s}_Foot",
        "L R",
    ),
    "Plain words, L and R": (
        "Pelvis Spine - - Chest Neck Head",
        "Clavicle.{s} UpperArm.{s} ForeArm.{s} Hand.{s} Thigh.{s} Shin.{s} Foot.{s} Toe.{s}",
        "L R",
    ),
    "Plain words, Left and Right": (
        "Pelvis Spine - - Chest Neck Head",
        "{s}_Collar_Bone {s}_Up_Arm {s}_Low_Arm {s}_Wrist {s}_Thigh {s}_Calf {s}_Ankle {s}_Ball",
        "left right",
    ),
    "MPFB and MakeHuman": (
        "root spine05 spine03 spine02 spine01 neck01 head",
        "clavicle.{s} upperarm01.{s} lowerarm01.{s} wrist.{s} upperleg01.{s} lowerleg01.{s} foot.{s} toe1-1.{s}",
        "L R",
    ),
}


def humanoid(preset: str) -> tuple[list[str], list[int], list[str]]:
    """Names, parents and the roles they should get."""
    centre, limbs, sides = (text.split() for text in TABLE[preset])
    names, parents, roles = ["Armature"], [-1], [""]
    for name, role in zip(centre, CENTRE, strict=True):
        if name != "-":
            parents.append(len(names) - 1)
            names.append(name)
            roles.append(role)
    chest = roles.index("neck") - 1
    for letter, side in zip("LR", sides, strict=True):
        for limb, part in zip(limbs, LIMBS, strict=True):
            start = (
                chest if part == "clavicle" else roles.index("hips") if part == "thigh" else len(names) - 1
            )
            parents.append(start)
            names.append(limb.replace("{s}", side))
            roles.append(f"{part}.{letter}")
    return names, parents, roles


@pytest.mark.parametrize("preset", TABLE)
def test_each_naming_is_recognised(preset: str):
    names, parents, roles = humanoid(preset)
    match = match_roles(names, np.array(parents))
    assert match.family == preset
    assert list(match.roles) == roles
    assert match.doubts == ()
    assert set(roles) - {""} <= set(ROLES)


def test_every_preset_that_ships_is_tested():
    assert {preset.name for preset in families().entries} == {*TABLE, "Rigify FK controls", "Roblox R15"}
    for path in (SHIPPED / KIND).glob("*.json"):
        text = path.read_text(encoding="utf-8")
        assert text == json.dumps(json.loads(text), indent=2) + "\n"


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(sorted(TABLE)),
    st.sampled_from(["", "mixamorig1:", "Character1_", "Bip01 ", "DEF-", "Armature|", "ns:deep:", "男 "]),
    st.sampled_from(
        [str, str.upper, str.lower, lambda s: s.replace("_", " "), lambda s: s.replace(".", "_")]
    ),
    st.randoms(use_true_random=False),
)
def test_prefixes_case_separators_and_order_do_not_matter(preset, prefix, spelling, random):
    names, parents, roles = humanoid(preset)
    order = list(range(len(names)))
    random.shuffle(order)
    place = {joint: at for at, joint in enumerate(order)}
    match = match_roles(
        [prefix + spelling(names[joint]) for joint in order],
        np.array([place.get(parents[joint], -1) for joint in order]),
    )
    assert list(match.roles) == [roles[joint] for joint in order]


def test_the_same_name_means_another_joint_in_another_scheme():
    for preset, role in [("Xsens", "upper_arm.L"), ("Mixamo", "clavicle.L"), ("SMPL", "upper_arm.L")]:
        names, parents, roles = humanoid(preset)
        match = match_roles(names, np.array(parents))
        shoulder = [name.lower().endswith(("leftshoulder", "left_shoulder")) for name in names].index(True)
        assert match.roles[shoulder] == role == roles[shoulder]


def test_names_that_hang_on_the_wrong_joints_do_not_match():
    names, parents, _ = humanoid("Mixamo")
    forearm = names.index("mixamorig:LeftForeArm")
    parents[forearm] = names.index("mixamorig:RightArm")
    with pytest.raises(InputError, match=r"Mixamo is nearest but lacks .*forearm\.L"):
        match_roles(names, np.array(parents))


@pytest.mark.parametrize("lost", ["Hips", "Head", "LeftHand", "RightLeg"])
def test_a_body_without_a_required_joint_is_refused(lost: str):
    names, parents, _ = humanoid("Mixamo")
    names[names.index(f"mixamorig:{lost}")] = "Thing"
    with pytest.raises(InputError) as error:
        match_roles(names, np.array(parents))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("part", ["Foot", "UpLeg"])
def test_feet_and_thighs_of_a_rig_may_hang_on_its_root(part: str):
    names, parents, roles = humanoid("Mixamo")
    names, parents, roles = ["root", *names], [-1, *(parent + 1 for parent in parents)], ["", *roles]
    for side in ("Left", "Right"):
        parents[names.index(f"mixamorig:{side}{part}")] = 0
    with pytest.raises(InputError, match="is nearest but lacks"):
        match_roles(names, np.array(parents))
    assert list(match_roles(names, np.array(parents), apart=True).roles) == roles


def test_a_rig_may_be_without_hands():
    names, parents, roles = humanoid("Mixamo")
    for side in ("Left", "Right"):
        roles[names.index(f"mixamorig:{side}Hand")] = ""
        names[names.index(f"mixamorig:{side}Hand")] = f"Thing{side}"
    assert list(match_roles(names, np.array(parents), needed=RIG_ROLES).roles) == roles


def test_a_body_without_optional_joints_is_taken():
    names, parents, roles = humanoid("LAFAN1")
    for name in ("LeftToe", "RightToe", "LeftShoulder", "RightShoulder", "Neck"):
        roles[names.index(name)] = ""
        names[names.index(name)] = "Thing"
    match = match_roles(names, np.array(parents))
    assert list(match.roles) == roles


@pytest.mark.parametrize("name", ["cube", "", "Left", "Hips"])
def test_things_that_are_no_bodies_are_refused(name: str):
    with pytest.raises(InputError):
        match_roles([name], np.array([-1]))
    with pytest.raises(InputError, match="no known joint names"):
        match_roles([], np.array([], dtype=np.intp))


@pytest.mark.parametrize(
    ("count", "expected"),
    [
        (0, []),
        (1, ["chest"]),
        (2, ["spine1", "chest"]),
        (3, ["spine1", "spine3", "chest"]),
        (4, ["spine1", "spine2", "spine3", "chest"]),
        (6, ["spine1", "", "spine2", "spine3", "", "chest"]),
    ],
)
def test_the_first_spine_joint_is_spine1_and_the_last_is_the_chest(count: int, expected: list[str]):
    names, parents, _ = humanoid("Bandai Namco")
    names[2:4] = ["Lower", "Upper"]
    chain = [f"Back{i}" for i in range(count)]
    kept = [joint for joint in range(len(names)) if names[joint] not in ("Lower", "Upper")]
    new_names = [names[joint] for joint in kept] + chain
    links = {name: names[parents[joint]] for joint, name in enumerate(names) if joint}
    top = chain[-1] if chain else "Hips"
    links |= {name: chain[i - 1] if i else "Hips" for i, name in enumerate(chain)}
    links |= dict.fromkeys(("Neck", "Shoulder_L", "Shoulder_R"), top)
    new_parents = [new_names.index(links[name]) if name in links else -1 for name in new_names]
    match = match_roles(new_names, np.array(new_parents))
    assert [match.roles[new_names.index(name)] for name in chain] == expected


def test_biped_collar_bones_on_the_neck_and_thighs_on_the_spine():
    names, parents, roles = humanoid("3ds Max Biped")
    for side in "LR":
        parents[names.index(f"Bip001_{side}_Clavicle")] = names.index("Bip001_Neck")
        parents[names.index(f"Bip001_{side}_Thigh")] = names.index("Bip001_Spine")
    assert list(match_roles(names, np.array(parents)).roles) == roles


def test_rigify_controls_are_preferred_to_deform_bones():
    # the parents of the control bones of a generated rig, from the hips upwards and outwards
    links = {
        "root": None,
        "torso": "root",
        "hips": "torso",
        "spine_fk.001": "torso",
        "spine_fk": "spine_fk.001",
        "ORG-spine": "spine_fk",
        "spine_fk.002": "torso",
        "spine_fk.003": "spine_fk.002",
        "ORG-spine.003": "spine_fk.003",
        "neck": "spine_fk.003",
        "MCH-ROT-head": "neck",
        "head": "MCH-ROT-head",
    }
    for side in "LR":
        links |= {
            f"shoulder.{side}": "ORG-spine.003",
            f"ORG-shoulder.{side}": "ORG-spine.003",
            f"upper_arm_fk.{side}": f"ORG-shoulder.{side}",
            f"forearm_fk.{side}": f"upper_arm_fk.{side}",
            f"hand_fk.{side}": f"forearm_fk.{side}",
            f"hand_ik.{side}": "root",
            f"DEF-upper_arm.{side}": f"ORG-shoulder.{side}",
            f"thigh_fk.{side}": "ORG-spine",
            f"shin_fk.{side}": f"thigh_fk.{side}",
            f"foot_fk.{side}": f"shin_fk.{side}",
            f"toe_fk.{side}": f"foot_fk.{side}",
        }
    names = list(links)
    parents = np.array([names.index(parent) if parent else -1 for parent in links.values()])
    match = match_roles(names, parents)
    found = dict(zip(match.roles, names, strict=True))
    assert match.family == "Rigify FK controls"
    assert found["hips"] == "torso"
    assert (found["spine1"], found["chest"]) == ("spine_fk.002", "spine_fk.003")
    assert found["clavicle.L"] == "shoulder.L"
    assert found["hand.R"] == "hand_fk.R"
    assert found["toe.R"] == "toe_fk.R"


def test_joints_of_one_name_raise_a_doubt():
    names, parents, roles = humanoid("LAFAN1")
    match = match_roles([*names, "LeftFoot"], np.array([*parents, 0]))
    assert list(match.roles) == [*roles, ""]
    assert len(match.doubts) == 1
    assert "LeftFoot" in match.doubts[0]


TAKES = {
    "xsens/JL_mm_tpose.bvh": ("Xsens", 23),
    "xsens/tposes/male_170_85.bvh": ("Xsens", 22),
    "lafan1/aiming1_subject1_walk_filtered.bvh": ("LAFAN1", 22),
    "lafan1/walk1_subject1_stop.bvh": ("LAFAN1", 22),
    "bandai_namco/dataset-2_raise-up-both-hands_normal_001.bvh": ("Bandai Namco", 21),
    "cmu/walk.bvh": ("CMU", 21),
    "cmu/007_10.bvh": ("Character Creator", 22),
    "cmu/basketball/006_08.bvh": ("Character Creator", 22),
    "cmu/dance_and_martial/salsa_25.bvh": ("Daz and Poser", 19),
    "fubot_vr/jobsimulator_2.bvh": ("Unity Humanoid", 22),
}


@pytest.mark.parametrize("take", TAKES)
def test_real_takes(data: Path, take: str):
    bvh = read_bvh(data / "takes" / take)
    match = match_roles(bvh.names, bvh.parents)
    assert (match.family, sum(role != "" for role in match.roles)) == TAKES[take]
    for name, role in zip(bvh.names, match.roles, strict=True):
        if role.endswith((".L", ".R")):
            left = name.startswith(("Left", "l", "CC_Base_L")) or name.endswith("_L")
            assert left == role.endswith(".L")


def german() -> tuple[list[str], np.ndarray, list[str], dict[str, Any]]:
    """Names, parents and roles of a body in a naming of its own, and the bone map for it."""
    names, parents, roles = humanoid("Mixamo")
    centre = {"hips": "Becken", "neck": "Hals", "head": "Kopf"}
    words = ["Schulter", "Oberarm", "Unterarm", "Hand", "Schenkel", "Wade", "Fuß", "Zeh"]
    joints = centre | {role: f"{word} {{side}}" for role, word in zip(LIMBS, words, strict=True)}
    for joint, role in enumerate(roles):
        part, _, side = role.partition(".")
        if part in joints:
            names[joint] = joints[part].replace("{side}", {"L": "links", "R": "rechts"}.get(side, ""))
    return names, np.array(parents), roles, {"name": "Own", "sides": ["links", "rechts"], "joints": joints}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's folder of bone maps."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    (tmp_path / KIND).mkdir()
    return tmp_path / KIND


def test_own_bone_maps(own: Path):
    names, parents, roles, bone_map = german()
    with pytest.raises(InputError, match="bone map") as error:
        match_roles(names, parents)
    assert str(own) in str(error.value), "it says where a bone map goes"
    (own / "own.json").write_text(json.dumps(bone_map), "utf-8")
    match = match_roles(names, parents)
    assert match.family == "Own"
    assert list(match.roles) == roles


def test_broken_bone_maps_of_the_user_leave_the_others_and_are_named_where_none_fits(own: Path):
    names, parents, roles, bone_map = german()
    (own / "a.json").write_text("{", "utf-8")
    (own / "b.json").write_text(json.dumps({**bone_map, "sides": "lr"}), "utf-8")
    (own / "c.json").write_text(json.dumps(bone_map), "utf-8")
    assert list(match_roles(names, parents).roles) == roles
    for family in TABLE:
        assert match_roles(humanoid(family)[0], np.array(humanoid(family)[1])).doubts == ()
    (own / "c.json").unlink()
    with pytest.raises(InputError) as error:
        match_roles(names, parents)
    assert "a.json: line 1: broken JSON" in str(error.value)
    assert "and 1 more" in str(error.value) and "\n" not in str(error.value)


def test_a_bone_map_of_the_user_takes_the_place_of_one_that_ships(own: Path):
    names, parents, roles = humanoid("Mixamo")
    shipped = json.loads((SHIPPED / KIND / "mixamo.json").read_text("utf-8"))
    # collar bones count as upper arms for this user
    arms = dict(zip(LIMBS[1:4], ["{side}Shoulder", "{side}Arm", "{side}ForeArm"], strict=True))
    changed = {**shipped["joints"], **arms}
    del changed["clavicle"]
    (own / "mine.json").write_text(json.dumps({**shipped, "joints": changed}), "utf-8")
    assert [family.name for family in families().entries].count("Mixamo") == 1
    match = match_roles(names, np.array(parents), [f for f in families().entries if f.name == "Mixamo"])
    assert match.roles[roles.index("clavicle.L")] == "upper_arm.L"
    assert match.roles[roles.index("forearm.R")] == "hand.R"


def test_a_spine_that_names_a_joint_of_the_limbs_takes_nothing_from_them(own: Path):
    names, parents, roles, bone_map = german()
    # with the prefix the spine's name is that of the hips
    (own / "own.json").write_text(json.dumps({**bone_map, "spine": ["X Becken"]}), "utf-8")
    match = match_roles([f"X {name}" for name in names], parents)
    assert match.roles[roles.index("hips")] == "hips"


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(sorted(TABLE)), st.data())
def test_any_bone_map_gives_a_whole_body_or_is_refused(tmp_path_factory, table: str, data):
    """A map that ships with some values replaced: no joint gets two roles, no limb is lost."""
    names, parents, _ = humanoid(table)
    texts = [path.read_text("utf-8") for path in (SHIPPED / KIND).glob("*.json")]
    content = next(found for found in map(json.loads, texts) if found["name"] == table)
    words = st.sampled_from(
        [*names, "{side}", "{side}a", "_", "", *(v for v in content["joints"].values() if isinstance(v, str))]
    )
    values = words | st.lists(words, max_size=3) | st.none() | st.integers()
    roles = st.sampled_from(["neck", "clavicle", "toe", "tail", *content["joints"]])
    content["joints"] |= data.draw(st.dictionaries(roles, values, max_size=2))
    content |= data.draw(
        st.dictionaries(st.sampled_from(["spine", "constrained", "sides"]), values, max_size=1)
    )
    path = tmp_path_factory.mktemp("maps") / "any.json"
    path.write_text(json.dumps(content), "utf-8")
    try:
        match = match_roles(names, np.array(parents), [read_family(path)])
    except InputError:
        return
    assert all(match.roles.count(role) == 1 for role in REQUIRED_ROLES)
    assert all(match.roles.count(role) <= 1 for role in ROLES)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"sides": ["links"]}, "'sides' is not a list of 2 texts"),
        ({"sides": ["rechts", "Rechts"]}, "same name"),
        ({"joints": None}, "'joints' is not an object"),
        ({"tail": "Schwanz"}, "'tail', which is none of name, sides, joints, spine, constrained"),
        ({"spine": "Wirbel"}, "'spine' is not a list"),
        ({"spine": ["Wirbel", "wirbel"]}, "same name"),
        ({"spine": ["Becken"]}, "'hips' and 'spine' have the same name"),
        ({"constrained": ["hips"]}, "'hips', which is none of clavicle"),
        ({"hips": 3}, "'hips' is not a list"),
        ({"hips": []}, "no hips"),
        ({"hips": ["Becken", {}]}, "item of 'hips'"),
        ({"hips": "_._"}, "without letters and digits"),
        ({"neck": "Kopf"}, "'neck' and 'head' have the same name 'kopf'"),
        ({"hand": "Hand"}, "without {side}"),
        ({"shin": "Schenkel {side}"}, "'thigh.L' and 'shin.L' have the same name"),
        ({"tongue": "Zunge"}, "tongue"),
    ],
)
def test_broken_bone_maps_say_what_is_wrong(tmp_path: Path, change: dict[str, Any], words: str):
    bone_map = german()[3]
    joints = {key: value for key, value in change.items() if key in (*CENTRE, *LIMBS, "tongue")}
    content = {**bone_map, **change, "joints": change.get("joints", {**bone_map["joints"], **joints})}
    if "joints" not in change:
        content = {key: value for key, value in content.items() if key not in joints}
    path = tmp_path / "broken.json"
    path.write_text(json.dumps(content), "utf-8")
    with pytest.raises(InputError) as error:
        read_family(path)
    assert words in str(error.value) and str(path) in str(error.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "broken JSON"),
        ("[1]", "not a bone map"),
        ('{"name": "x", "sides": ["L", "R"]}', "joints"),
        ('{"name": "x", "sides": ["L"], "joints": {"hand": "a"}}', "not a bone map"),
        ('{"name": "x", "sides": ["L", "R"], "joints": {"tail": "a"}}', "tail"),
        ('{"name": "x", "sides": ["L", "R"], "joints": {"hips": "a"}}', "head"),
    ],
)
def test_broken_bone_maps_are_refused(tmp_path: Path, text: str, words: str):
    path = tmp_path / "broken.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words) as error:
        read_family(path)
    assert str(path) in str(error.value)
