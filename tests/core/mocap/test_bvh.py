"""Reading and writing BVH against upc-pymotion, scipy and the format's own variety."""

from __future__ import annotations

import hashlib
import string
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.forward_kinematics import forward as joints_forward
from footwork.core.mocap.bvh import (
    CHANNELS,
    BvhFile,
    format_bvh,
    local_transforms,
    parse_bvh,
    read_bvh,
    write_bvh,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

pytestmark = pytest.mark.filterwarnings("error")

SMALL = """HIERARCHY
ROOT Hips
{
	OFFSET 1.0 2.0 3.0
	CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
	JOINT Spine
	{
		OFFSET 0.0 10.0 0.5
		CHANNELS 3 Yrotation Xrotation Zrotation
		End Site
		{
			OFFSET 0.0 5.0 0.0
		}
	}
}
MOTION
Frames: 2
Frame Time: 0.033333
1 2 3 10 20 30 40 50 60
-1.5 2e1 3.25E-1 -10 -20 -30 .5 -.25 1.e0
"""
TAKES = [
    "xsens/100STYLE_Neutral_FW.bvh",
    "lafan1/aiming1_subject1_walk2_filtered.bvh",
    "bandai_namco/dataset-2_walk-turn-left_normal_001.bvh",
    "cmu/007_01.bvh",
    "cmu/dance_and_martial/salsa_10.bvh",
    "fubot_vr/jobsimulator_2.bvh",
]


def assert_equal(a: BvhFile, b: BvhFile) -> None:
    assert (a.names, a.channels, a.frame_time) == (b.names, b.channels, b.frame_time)
    for x, y in [
        (a.parents, b.parents),
        (a.end_parents, b.end_parents),
        (a.offsets, b.offsets),
        (a.end_sites, b.end_sites),
        (a.values, b.values),
    ]:
        assert x.shape == y.shape
        assert x.tobytes() == y.tobytes()


def test_everything_in_a_small_file():
    bvh = parse_bvh(SMALL.encode(), "small.bvh")
    assert bvh.names == ("Hips", "Spine")
    assert bvh.parents.tolist() == [-1, 0]
    assert bvh.offsets.tolist() == [[1.0, 2.0, 3.0], [0.0, 10.0, 0.5]]
    assert bvh.channels[0][:4] == ("Xposition", "Yposition", "Zposition", "Zrotation")
    assert bvh.channels[1] == ("Yrotation", "Xrotation", "Zrotation")
    assert bvh.end_sites.tolist() == [[0.0, 5.0, 0.0]]
    assert bvh.end_parents.tolist() == [1]
    assert bvh.frame_time == 0.033333
    assert bvh.values.tolist() == [
        [1, 2, 3, 10, 20, 30, 40, 50, 60],
        [-1.5, 20.0, 0.325, -10, -20, -30, 0.5, -0.25, 1.0],
    ]
    assert bvh.file == "small.bvh"
    assert bvh.sha256 == hashlib.sha256(SMALL.encode()).hexdigest()
    assert len(bvh) == 2


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("\n", "\r"),
        lambda t: "\ufeff" + t,
        lambda t: t.replace("\t", "  "),
        lambda t: t.replace("\n{", " {").replace("Site\n\t\t{", "Site {"),
        lambda t: t.replace("\n\t\t\t", " ").replace("\n\t\t}", " }"),
        lambda t: t.replace("HIERARCHY", "hierarchy").replace("ROOT", "Root").replace("MOTION", "Motion"),
        lambda t: t.replace("Xrotation", "xrotation").replace("Yposition", "YPOSITION"),
        lambda t: t.replace("Frames: 2", "Frames:\t2 "),
        lambda t: t.replace("Frames: 2", "FRAMES : 2").replace("Frame Time:", "Frame time :"),
        lambda t: t.replace(" Time: ", " Time:\t"),
        lambda t: t.replace("1 2 3", " \t1\t2  3").replace("60\n", "60 \n\n"),
        lambda t: t.replace("\n", "\n\n"),
        lambda t: t.rstrip("\n"),
        lambda t: t + "\n \n\n",
        lambda t: t.replace("End Site", "End Site Spine_end"),
    ],
)
def test_variants_read_the_same(change):
    assert_equal(parse_bvh(change(SMALL).encode(), "x"), parse_bvh(SMALL.encode(), "x"))


def test_names_with_spaces_namespaces_and_other_scripts():
    text = SMALL.replace("ROOT Hips", "ROOT Bip01 Pelvis \t").replace(
        "JOINT Spine", "JOINT mixamorig:脊椎 MOTION"
    )
    names = ("Bip01 Pelvis", "mixamorig:脊椎 MOTION")
    assert parse_bvh(text.encode(), "x").names == names
    assert parse_bvh(format_bvh(parse_bvh(text.encode(), "x")).encode(), "x").names == names
    assert parse_bvh(text.encode("cp932"), "x").names[0] == names[0]


@pytest.mark.parametrize("take", TAKES)
def test_round_trip_of_real_takes_is_exact(data: Path, tmp_path: Path, take: str):
    bvh = read_bvh(data / "takes" / take)
    assert bvh.sha256 == hashlib.sha256((data / "takes" / take).read_bytes()).hexdigest()
    write_bvh(tmp_path / "out.bvh", bvh)
    assert_equal(read_bvh(tmp_path / "out.bvh"), bvh)


@st.composite
def files(draw: st.DrawFn) -> BvhFile:
    count = draw(st.integers(1, 6))
    numbers = st.floats(-9e8, 9e8)
    # a hierarchy in depth-first order, as a file lists it
    parents, path = [-1], [0]
    for joint in range(1, count):
        del path[draw(st.integers(1, len(path))) :]
        parents.append(path[-1])
        path.append(joint)
    turns = st.lists(st.sampled_from(CHANNELS[3:]), max_size=3)
    moves = st.lists(st.sampled_from(CHANNELS[:3]), max_size=3, unique=True)
    channels = [tuple(draw(st.permutations(draw(moves) + draw(turns)))) for _ in range(count)]
    ends = sorted(draw(st.lists(st.integers(0, count - 1), max_size=4)))
    letters = st.text(string.ascii_letters + "_:é脊-. 7", min_size=1, max_size=8).map(str.strip).filter(bool)
    array = lambda *shape: draw(hnp.arrays(np.float64, shape, elements=numbers))  # noqa: E731
    return BvhFile(
        names=tuple(draw(letters) for _ in range(count)),
        parents=np.array(parents, dtype=np.intp),
        offsets=array(count, 3),
        channels=tuple(channels),
        end_sites=array(len(ends), 3),
        end_parents=np.array(ends, dtype=np.intp),
        frame_time=draw(st.floats(1e-6, 10.0)),
        values=array(draw(st.integers(1, 4)), sum(map(len, channels))),
        file="x",
        sha256="",
    )


@settings(max_examples=150, deadline=None)
@given(files())
def test_round_trip_is_exact(bvh: BvhFile):
    assert_equal(parse_bvh(format_bvh(bvh).encode(), "x"), bvh)


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YXZ", "ZYX", "YZX", "XZY", "ZXZ", "YX", "Z", ""])
def test_rotations_of_any_order_agree_with_scipy(order: str):
    channels = " ".join(f"{axis}rotation" for axis in order)
    text = SMALL.replace("CHANNELS 3 Yrotation Xrotation Zrotation", f"CHANNELS {len(order)} {channels}")
    angles = np.random.default_rng(3).uniform(-170, 170, (4, len(order)))
    body = "\n".join("0 0 0 0 0 0 " + " ".join(map(repr, row)) for row in angles.tolist())
    text = text.split("MOTION")[0] + f"MOTION\nFrames: 4\nFrame Time: 0.1\n{body}\n"
    _, rotations = local_transforms(parse_bvh(text.encode(), "x"))
    for q, row in zip(rotations[:, 1], angles, strict=True):
        expected = Rotation.identity()
        for axis, angle in zip(order, row, strict=True):
            expected = expected * Rotation.from_euler(axis, angle, degrees=True)
        assert abs(np.roll(expected.as_quat(), 1) @ q) == pytest.approx(1.0, abs=1e-12)


def test_position_channels_replace_the_offset_axis_by_axis():
    text = SMALL.replace("CHANNELS 3 Yrotation Xrotation Zrotation", "CHANNELS 1 Yposition")
    text = text.replace("40 50 60", "40").replace(".5 -.25 1.e0", "7")
    positions, _ = local_transforms(parse_bvh(text.encode(), "x"))
    assert positions[:, 0].tolist() == [[1, 2, 3], [-1.5, 20, 0.325]]
    assert positions[:, 1].tolist() == [[0, 40, 0.5], [0, 7, 0.5]]


def test_joints_out_of_file_order_are_not_written():
    bvh = parse_bvh(SMALL.replace("JOINT Spine", "JOINT A\n{\nOFFSET 0 0 0\n}\nJOINT Spine").encode(), "x")
    assert bvh.names == ("Hips", "A", "Spine")
    with pytest.raises(ValueError, match="file order"):
        format_bvh(replace(bvh, parents=np.array([-1, 2, 0])))


@pytest.mark.parametrize("take", TAKES)
def test_forward_kinematics_agrees_with_pymotion(data: Path, take: str):
    from pymotion.io.bvh import BVH
    from pymotion.ops.skeleton_np import fk

    path = data / "takes" / take
    theirs = BVH()
    theirs.load(str(path))
    rotations, positions, parents, _, _, _ = theirs.get_data()
    bvh = read_bvh(path)
    assert list(bvh.names) == list(theirs.data["names"])
    frames = np.unique(np.linspace(0, len(bvh) - 1, 15).astype(int))
    expected, matrices = fk(rotations[frames], positions[frames, 0], positions[frames], np.array(parents))
    local, turns = (x[frames] for x in local_transforms(bvh))
    ours, turned = joints_forward(local[:, 0], turns, local, bvh.parents)
    np.testing.assert_allclose(ours, expected, atol=1e-6 * np.abs(expected).max())
    axes = Rotation.from_quat(np.roll(turned, -1, axis=-1).reshape(-1, 4)).as_matrix()
    np.testing.assert_allclose(axes.reshape(matrices.shape), matrices, atol=1e-6)
