"""Joint roles: the tables of the naming schemes, prefixes, hierarchy, and what must not match."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.skeleton import ROLES
from footwork.core.errors import InputError
from footwork.core.mocap.bvh import read_bvh
from footwork.core.mocap.roles import PRESETS, match_roles, read_preset, shipped_presets
from hypothesis import given, settings
from hypothesis import strategies as st

CENTRE = ("hips", "spine1", "spine2", "spine3", "chest", "neck", "head")
LIMBS = ("clavicle", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toe")
# hips to head ("" for none, extra joints in between have role ""), then left limbs with {s} for the side
TABLE = {
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
    assert match.preset == preset
    assert list(match.roles) == roles
    assert match.doubts == ()
    assert set(roles) - {""} <= set(ROLES)


def test_every_preset_that_ships_is_tested():
    assert {preset.name for preset in shipped_presets()} == {*TABLE, "Rigify FK controls"}
    for path in PRESETS.glob("*.json"):
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
    assert match.preset == "Rigify FK controls"
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
    assert (match.preset, sum(role != "" for role in match.roles)) == TAKES[take]
    for name, role in zip(bvh.names, match.roles, strict=True):
        if role.endswith((".L", ".R")):
            left = name.startswith(("Left", "l", "CC_Base_L")) or name.endswith("_L")
            assert left == role.endswith(".L")


def test_own_bone_maps(tmp_path: Path):
    names, parents, roles = humanoid("Mixamo")
    german = {"hips": "Becken", "neck": "Hals", "head": "Kopf"}
    german |= dict(
        zip(LIMBS, ["Schulter", "Oberarm", "Unterarm", "Hand", "Schenkel", "Wade", "Fuß", "Zeh"], strict=True)
    )
    for joint, role in enumerate(roles):
        part, _, side = role.partition(".")
        if part in german:
            names[joint] = german[part] + {"": "", "L": " links", "R": " rechts"}[side]
    path = tmp_path / "own.json"
    joints = {role: name + " {side}" * (role in LIMBS) for role, name in german.items()}
    path.write_text(json.dumps({"name": "Own", "sides": ["links", "rechts"], "joints": joints}), "utf-8")
    with pytest.raises(InputError):
        match_roles(names, np.array(parents))
    match = match_roles(names, np.array(parents), [*shipped_presets(), read_preset(path)])
    assert match.preset == "Own"
    assert list(match.roles) == roles


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a bone map"),
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
        read_preset(path)
    assert str(path) in str(error.value)
