"""Naming schemes of nobody's: words of languages that no list has, prefixes, sides by number or by one suffix alone."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.roles import match_roles

MOTION = demo_motion("turn", 3)
SKELETON = MOTION.skeleton
NAMES = {
    "polish": (
        "{0}_{1}",
        {"L": "lewa", "R": "prawa"},
        {
            "hips": "miednica",
            "spine1": "kregoslup1",
            "spine2": "kregoslup2",
            "spine3": "kregoslup3",
            "chest": "klatka",
            "neck": "szyja",
            "head": "glowa",
            "clavicle": "obojczyk",
            "upper_arm": "ramie",
            "forearm": "przedramie",
            "hand": "dlon",
            "thigh": "udo",
            "shin": "golen",
            "foot": "stopa",
            "toe": "palce",
        },
    ),
    "russian": (
        "{1}_{0}",
        {"L": "lev", "R": "prav"},
        {
            "hips": "taz",
            "spine1": "pozv1",
            "spine2": "pozv2",
            "spine3": "pozv3",
            "chest": "grud",
            "neck": "sheya",
            "head": "golova",
            "clavicle": "klyuchica",
            "upper_arm": "plecho",
            "forearm": "predplechye",
            "hand": "kist",
            "thigh": "bedro",
            "shin": "golen",
            "foot": "stopa",
            "toe": "noski",
        },
    ),
    "korean": (
        "{0}{1}",
        {"L": "_oen", "R": "_oreun"},
        {
            "hips": "golban",
            "spine1": "cheokchu1",
            "spine2": "cheokchu2",
            "spine3": "cheokchu3",
            "chest": "gaseum",
            "neck": "mok",
            "head": "meori",
            "clavicle": "swaegol",
            "upper_arm": "witpal",
            "forearm": "araetpal",
            "hand": "son",
            "thigh": "heobeokji",
            "shin": "jongari",
            "foot": "balmok",
            "toe": "balgarak",
        },
    ),
    "trailing12": (
        "{0}_{1}",
        {"L": "1", "R": "2"},
        {
            "hips": "pelvis",
            "spine1": "spineA",
            "spine2": "spineB",
            "spine3": "spineC",
            "chest": "chest",
            "neck": "neck",
            "head": "head",
            "clavicle": "clav",
            "upper_arm": "uparm",
            "forearm": "loarm",
            "hand": "hand",
            "thigh": "thigh",
            "shin": "calf",
            "foot": "foot",
            "toe": "toe",
        },
    ),
    "ns": (
        "Hero:rig:{1}{0}_JNT",
        {"L": "L_", "R": "R_"},
        {
            "hips": "root",
            "spine1": "sp1",
            "spine2": "sp2",
            "spine3": "sp3",
            "chest": "sp4",
            "neck": "nk",
            "head": "hd",
            "clavicle": "clv",
            "upper_arm": "arm",
            "forearm": "elb",
            "hand": "wri",
            "thigh": "leg",
            "shin": "kne",
            "foot": "ank",
            "toe": "bal",
        },
    ),
    "mirrorX": (
        "{0}{1}",
        {"L": "", "R": ".X"},
        {
            "hips": "Pelvis",
            "spine1": "Spine1",
            "spine2": "Spine2",
            "spine3": "Spine3",
            "chest": "Chest",
            "neck": "Neck",
            "head": "Head",
            "clavicle": "Clavicle",
            "upper_arm": "UpperArm",
            "forearm": "Forearm",
            "hand": "Hand",
            "thigh": "Thigh",
            "shin": "Shin",
            "foot": "Foot",
            "toe": "Toe",
        },
    ),
    "soma": (
        "{1}{0}",
        {"L": "Left", "R": "Right"},
        {
            "hips": "Hips",
            "spine1": "Spine1",
            "spine2": "Spine2",
            "spine3": "Spine3",
            "chest": "Chest",
            "neck": "Neck1",
            "head": "Head",
            "clavicle": "Shoulder",
            "upper_arm": "Arm",
            "forearm": "ForeArm",
            "hand": "Hand",
            "thigh": "Leg",
            "shin": "Shin",
            "foot": "Foot",
            "toe": "ToeBase",
        },
    ),
    "daz": (
        "{1}{0}",
        {"L": "l", "R": "r"},
        {
            "hips": "hip",
            "spine1": "abdomenLower",
            "spine2": "abdomenUpper",
            "spine3": "chestLower",
            "chest": "chestUpper",
            "neck": "neckLower",
            "head": "head",
            "clavicle": "Collar",
            "upper_arm": "ShldrBend",
            "forearm": "ForearmBend",
            "hand": "Hand",
            "thigh": "ThighBend",
            "shin": "Shin",
            "foot": "Foot",
            "toe": "Toe",
        },
    ),
}


def named(scheme: str) -> list[str]:
    if scheme not in NAMES:
        return [f"bone_{number:02d}" for number in range(len(SKELETON))]
    pattern, sides, words = NAMES[scheme]
    names: list[str] = []
    for role in SKELETON.roles:
        part, _, side = role.partition(".")
        name = pattern.format(words[part], sides[side] if side else "")
        names.append(name if side else name.strip("_"))
    return names


@pytest.mark.parametrize("kind", ["take", "rig"])
@pytest.mark.parametrize("scheme", [*NAMES, "numbers"])
def test_every_joint_gets_its_role(scheme: str, kind: str) -> None:
    rows = np.linspace(0, len(MOTION) - 1, 12).astype(int)
    poses = MOTION.forward()[0][rows] if kind == "take" else SKELETON.tpose_positions()[None]
    match = match_roles(named(scheme), SKELETON.parents, poses=lambda: poses, apart=kind == "rig")
    assert match.roles == SKELETON.roles
    # what no known naming says is doubted
    assert match.doubts or match.family == "Daz and Poser"
