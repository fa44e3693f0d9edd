"""Skeletons with names of no known naming, recognised by words and by structure."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.skeleton import Skeleton
from footwork.core.errors import InputError
from footwork.core.mocap.bvh import BvhFile, write_bvh
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.recognise.words import read_names
from footwork.core.mocap.roles import match_roles
from footwork.core.mocap.takes import load_take
from scipy.spatial.transform import Rotation

SKELETON = demo_skeleton(1.72)

WORDS = {
    "german": (
        "{}.{}",
        {"L": "li", "R": "re"},
        {
            "hips": "Becken", "spine1": "Bauch", "spine2": "Ruecken", "spine3": "Rücken2", "chest": "Brust",
            "neck": "Hals", "head": "Kopf", "clavicle": "Schlüsselbein", "upper_arm": "Oberarm", "forearm": "Unterarm",
            "hand": "Hand", "thigh": "Oberschenkel", "shin": "Unterschenkel", "foot": "Fuß", "toe": "Zehen",
        },
    ),
    "spanish": (
        "{}_{}",
        {"L": "izq", "R": "der"},
        {
            "hips": "pelvis", "spine1": "columna1", "spine2": "columna2", "spine3": "columna3", "chest": "pecho",
            "neck": "cuello", "head": "cabeza", "clavicle": "clavicula", "upper_arm": "brazo", "forearm": "antebrazo",
            "hand": "mano", "thigh": "muslo", "shin": "pantorrilla", "foot": "pie", "toe": "puntera",
        },
    ),
    "studio": (
        "ABC_hero_{1}_{0}_jnt_v02",
        {"L": "lft", "R": "rgt"},
        {
            "hips": "cog", "spine1": "torsoA", "spine2": "torsoB", "spine3": "torsoC", "chest": "ribcage",
            "neck": "cervical", "head": "skull", "clavicle": "collar", "upper_arm": "humerus", "forearm": "radius",
            "hand": "wrist", "thigh": "femur", "shin": "tibia", "foot": "ankle", "toe": "ball",
        },
    ),
    "japanese": (
        "{1}{0}",
        {"L": "左", "R": "右"},
        {
            "hips": "腰", "spine1": "脊椎1", "spine2": "脊椎2", "spine3": "脊椎3", "chest": "胸",
            "neck": "首", "head": "頭", "clavicle": "鎖骨", "upper_arm": "上腕", "forearm": "前腕", "hand": "手首",
            "thigh": "太もも", "shin": "すね", "foot": "足首", "toe": "つま先",
        },
    ),
    "numbers": ("", {}, {}),
}  # fmt: skip


def renamed(skeleton: Skeleton, language: str) -> tuple[str, ...]:
    pattern, sides, words = WORDS[language]
    if not words:
        return tuple(f"Bone.{number:03d}" for number in range(len(skeleton)))
    names: list[str] = []
    for role in skeleton.roles:
        part, _, side = role.partition(".")
        word = words[part]
        centre = pattern.replace("{1}_", "").replace("{1}", "").replace(".{}", "").replace("_{}", "")
        names.append(
            pattern.format(word, sides[side]) if side else centre.replace("{0}", word).replace("{}", word)
        )
    return tuple(names)


def some_poses(count: int = 8) -> np.ndarray:
    motion = demo_motion("turn", 3)
    rows = np.linspace(0, len(motion) - 1, count).astype(int)
    return motion.forward()[0][rows]


@pytest.mark.parametrize("language", WORDS)
def test_roles_by_words_of_any_language_or_by_structure_alone(language: str) -> None:
    motion = demo_motion("turn", 3)
    skeleton = motion.skeleton
    names = renamed(skeleton, language)
    found = match_roles(names, skeleton.parents, poses=some_poses)
    for role, known in zip(found.roles, skeleton.roles, strict=True):
        # a spine's inner joints have roles by their number
        assert role == known or known in ("spine1", "spine2", "spine3"), (role, known)
    assert any("look at them" in doubt for doubt in found.doubts)


@pytest.mark.parametrize("seed", range(6))
def test_axes_order_and_size_do_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion = demo_motion("turn", 3)
    skeleton = motion.skeleton
    order = rng.permutation(len(skeleton))
    place = np.argsort(order)
    parents = np.array([place[p] if p >= 0 else -1 for p in skeleton.parents[order]])
    turn = Rotation.random(random_state=seed).as_matrix()
    poses = (some_poses() @ turn.T * rng.uniform(0.01, 300.0) + rng.normal(size=3))[:, order]
    found = match_roles([f"n{i}" for i in range(len(order))], parents, poses=lambda: poses)
    got = [found.roles[place[j]] for j in range(len(skeleton))]
    wrong = [(a, b) for a, b in zip(got, skeleton.roles, strict=True) if a != b and b[:5] != "spine"]
    assert wrong == []


def test_a_take_with_unknown_names_is_read_as_the_same_motion(tmp_path: Path) -> None:
    motion = demo_motion("turn", 3)
    bvh = to_bvh(motion, "walk")
    known = dict(zip(motion.skeleton.names, motion.skeleton.roles, strict=True))
    _, sides, words = WORDS["german"]

    def german(name: str) -> str:
        part, _, side = known.get(name, "").partition(".")
        return name if not part else f"{words[part]}_{sides[side]}" if side else words[part]

    write_bvh(tmp_path / "a.bvh", bvh)
    write_bvh(tmp_path / "b.bvh", replace(bvh, names=tuple(german(name) for name in bvh.names)))
    plain, other = load_take(tmp_path / "a.bvh"), load_take(tmp_path / "b.bvh")
    np.testing.assert_allclose(other.motion.forward()[0], plain.motion.forward()[0], atol=1e-6)
    assert other.motion.skeleton.roles == plain.motion.skeleton.roles
    assert "names and structure" in other.found["joint names"]


@pytest.mark.parametrize(
    ("name", "side", "part"),
    [
        ("mixamorig:LeftUpLeg", "L", "thigh"), ("Bip01 R Forearm", "R", "forearm"),
        ("DEF-upper_arm.L", "L", "upper_arm"),
        ("lThigh", "L", "thigh"), ("handr", "R", "hand"), ("Oberschenkel.rechts", "R", "thigh"),
        ("j_bip_c_hips", "", "hips"),
        ("左足首", "L", "foot"), ("CC_Base_L_Calf", "L", "shin"), ("rightShoulder", "R", "clavicle"),
        ("spine_03", "", "spine"),
    ],
)  # fmt: skip
def test_what_names_say(name: str, side: str, part: str) -> None:
    (said,) = read_names([name])
    assert said.side == side and max(said.parts, key=said.parts.__getitem__) == part


@pytest.mark.parametrize(
    "name", ["LeftHandIndex1", "upperarm_twist_01_l", "MCH-hand_ik.L", "ik_foot_root", "Eye.R"]
)
def test_names_of_helpers_say_no_part(name: str) -> None:
    (said,) = read_names([name])
    assert said.dim or said.mechanism


def test_a_spider_is_no_person() -> None:
    parents = [-1, 0]
    places = [(0.0, 0.0, 0.3), (0.0, 0.2, 0.3)]
    for leg in range(8):
        angle = 2.0 * np.pi * leg / 8
        for joint in range(3):
            parents.append(0 if joint == 0 else len(parents) - 1)
            reach = 0.2 * (joint + 1)
            places.append((reach * np.cos(angle), reach * np.sin(angle), 0.3 - 0.1 * joint))
    with pytest.raises(InputError, match="person"):
        match_roles(
            [f"b{i}" for i in range(len(parents))], np.array(parents), poses=lambda: np.array([places])
        )


def test_a_tree_from_the_head_down_is_named() -> None:
    motion = demo_motion("turn", 3)
    skeleton = motion.skeleton
    parents = skeleton.parents.copy()
    chain = [skeleton.joint("head")]
    while chain[-1] != 0:
        chain.append(int(parents[chain[-1]]))
    for upper, lower in itertools.pairwise(chain):
        parents[lower] = upper
    parents[chain[0]] = -1
    names = [f"x_{name}" for name in skeleton.names]
    with pytest.raises(InputError, match=r"above the hips|person"):
        match_roles(names, parents, poses=some_poses)


def edited(path: Path, bvh: BvhFile, change) -> Path:
    write_bvh(path, bvh)
    data = change(path.read_bytes())
    path.write_bytes(data)
    return path


@pytest.mark.parametrize(
    ("change", "doubt"),
    [
        (lambda data: data.decode().encode("utf-16"), ""),
        (lambda data: data.replace(b"End Site", b"EndSite"), ""),
        (lambda data: data + b"\x1a", "Ctrl-Z"),
        (lambda data: data.replace(b"Frames: 121", b"Frames: 0"), "Frames: 0"),
    ],
)
def test_odd_files_are_read(tmp_path: Path, change, doubt: str) -> None:
    motion = demo_motion("turn", 3)
    bvh = replace(to_bvh(motion, "walk"))
    bvh = replace(bvh, values=bvh.values[:121])
    plain = load_take(edited(tmp_path / "a.bvh", bvh, lambda data: data))
    odd = load_take(edited(tmp_path / "b.bvh", bvh, change))
    np.testing.assert_array_equal(odd.motion.rotations, plain.motion.rotations)
    assert (doubt == "" and odd.doubts == plain.doubts) or any(doubt in line for line in odd.doubts)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: data.replace(b".", b","), "decimal commas"),
        (lambda data: data[: data.index(b"Frames")] + b"Frames: 0\nFrame Time: 0.02\n", "no frames"),
        (lambda data: data.replace(b"Frame Time: 0.016666666666666666", b"Frame Time: 60"), "--rate 60"),
    ],
)
def test_faults_of_files_are_named(tmp_path: Path, change, words: str) -> None:
    bvh = to_bvh(demo_motion("turn", 3), "walk")
    with pytest.raises(InputError, match=words):
        load_take(edited(tmp_path / "a.bvh", bvh, change))


@pytest.mark.parametrize(("time", "rate"), [(0.017, 60.0), (0.033, 30.0), (0.0083, 120.0), (0.04, 25.0)])
def test_short_frame_times_are_the_usual_rates(tmp_path: Path, time: float, rate: float) -> None:
    bvh = replace(to_bvh(demo_motion("turn", 3), "walk"), frame_time=time)
    write_bvh(tmp_path / "a.bvh", bvh)
    take = load_take(tmp_path / "a.bvh")
    assert take.motion.fps == rate
    assert any(f"1/{rate:g}" in doubt for doubt in take.doubts) == (abs(time * rate - 1.0) > 0.005)


def test_a_walk_in_place_is_doubted(tmp_path: Path) -> None:
    bvh = to_bvh(demo_motion("walk", 3), "walk")
    values = bvh.values.copy()
    values[:, [0, 2]] = 0.0
    names = bvh.channels[0][:3]
    assert names == ("Xposition", "Yposition", "Zposition")
    write_bvh(tmp_path / "a.bvh", replace(bvh, values=values))
    write_bvh(tmp_path / "b.bvh", bvh)
    assert any("in place" in doubt for doubt in load_take(tmp_path / "a.bvh").doubts)
    assert not any("in place" in doubt for doubt in load_take(tmp_path / "b.bvh").doubts)


assert len(SKELETON) == len(SKELETON.roles)
