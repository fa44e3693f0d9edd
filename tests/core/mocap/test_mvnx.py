"""MVNX takes: read as the motion that they were made of, and broken ones refused in one line."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.edit import resample
from footwork.core.body.pose import role_poses
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.answers import TakeAnswers
from footwork.core.mocap.bvh import write_bvh
from footwork.core.mocap.containers import container_of
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.takes import is_take, load_take

SPEC = importlib.util.spec_from_file_location(
    "fuzz_mvnx", Path(__file__).parents[3] / "tools" / "fuzz_mvnx.py"
)
assert SPEC is not None and SPEC.loader is not None
made = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(made)
format_mvnx = made.format_mvnx

MOTION = resample(demo_motion("turn", 3), 40.0)
ROLES = tuple(role for role in MOTION.skeleton.roles if role)


def written(path: Path, text: str, encoding: str = "utf-8") -> Path:
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(("joints", "tpose"), [(True, True), (False, True), (True, False)])
def test_a_take_is_the_motion_it_was_made_of(tmp_path: Path, joints: bool, tpose: bool) -> None:
    take = load_take(written(tmp_path / "a.mvnx", format_mvnx(MOTION, joints=joints, tpose=tpose)))
    assert take.found["joint names"].startswith("Xsens MVN") and take.motion.fps == 40.0
    assert take.found["up axis"] == "Z" and take.found["unit"].startswith("m ")
    wanted, turns = role_poses(MOTION, ROLES)
    places, found = role_poses(take.motion, ROLES)
    # the file's world: X ahead
    turn = quat.from_yaw(-0.5 * np.pi)
    assert np.abs(places - quat.rotate(turn, wanted))[..., :2].max() < 1e-5
    rise = places[..., 2] - wanted[..., 2]
    assert np.ptp(rise) < 1e-5 and abs(rise.mean()) < 0.05
    off = quat.multiply(found, quat.conjugate(quat.multiply(turn, turns)))
    assert np.degrees(np.linalg.norm(quat.to_rotation_vector(off), axis=-1)).max() < 0.1
    assert len(take.doubts) == (not tpose)


def test_content_decides_and_encodings_do_not_matter(tmp_path: Path) -> None:
    head = '<?xml version="1.0" encoding="UTF-16"?>'
    for name, encoding, start in (("take.bvh", "utf-8", ""), ("take.txt", "utf-16", head)):
        path = written(tmp_path / name, format_mvnx(MOTION, head=start).lstrip(), encoding)
        assert is_take(path) and load_take(path).found["joint names"].startswith("Xsens MVN")
    write_bvh(tmp_path / "b.mvnx", to_bvh(MOTION, "b"))
    found = container_of(tmp_path / "b.mvnx")
    assert found is not None and found.name == "BVH"


BOMB = (
    '<?xml version="1.0"?><!DOCTYPE mvnx [<!ENTITY a "lol lol lol lol">'
    + "".join(f'<!ENTITY {b} "{("&" + a + ";") * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
    + "]><mvnx>&i;</mvnx>"
)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: BOMB, "document type"),
        (lambda text: text.replace("?>", '?><!DOCTYPE mvnx SYSTEM "file:///etc/passwd">', 1), "document type"),
        (lambda text: text[: len(text) // 2], r"line \d+: broken XML"),
        (lambda text: text.replace("</frames>", ""), "broken XML"),
        (lambda text: text.replace("<position>", "<position>1.5 ", 3), "70 numbers in position where 23"),
        (lambda text: text.replace("<position>0.", "<position>x"), "word among the numbers"),
        (lambda text: text.replace("<position>0.", "<position>1e999", 1), "not finite"),
        (lambda text: text.replace("<orientation>", "<o>").replace("</orientation>", "</o>"), "without orientation"),
        (lambda text: text.replace('type="normal"', 'type="other"'), "no frames"),
        (lambda text: text.replace('frameRate="40"', 'frameRate="many"'), "--rate"),
        (lambda text: text.replace("<comment>", '<subject frameRate="9"/><comment>'), "2 people"),
        (lambda text: text.replace('label="T8"', 'label="L3"'), "two of one name"),
        (lambda text: text.replace("<connector1>Pelvis/", "<connector1>Toe/"), "do not hang together"),
        (lambda text: text.replace("<connector2>L5/j1<", "<connector2>Pelvis/j1<"), "do not hang together"),
        (lambda text: text.replace("<comment>", "<a>" * 300), "nested too deeply"),
    ],
)  # fmt: skip
def test_faults_are_named_in_one_line(tmp_path: Path, change, words: str) -> None:
    path = written(tmp_path / "a.mvnx", change(format_mvnx(MOTION)))
    with pytest.raises(InputError, match=words) as caught:
        load_take(path)
    assert len(caught.value.lines) == 1 and str(path) in str(caught.value)


def test_a_stated_rate_takes_the_place_of_one_that_is_none(tmp_path: Path) -> None:
    path = written(tmp_path / "a.mvnx", format_mvnx(MOTION).replace('frameRate="40"', ""))
    assert load_take(path, answers=TakeAnswers(rate=48.0)).motion.fps == 48.0
