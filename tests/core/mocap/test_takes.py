"""Takes: known motions come back from files in other units, axes and rates; what real files hold is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.edit import cut, mirror, resample
from footwork.core.body.motion import Motion
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.answers import TakeAnswers
from footwork.core.mocap.bvh import BvhFile, read_bvh, write_bvh
from footwork.core.mocap.checks import toes_aside
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.takes import frame_rate, load_take, take_from_bvh

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(scope="module")
def walk() -> Motion:
    return cut(demo_motion("turn", 3), 0, 400)


@pytest.fixture(scope="module")
def file(walk: Motion) -> BvhFile:
    return to_bvh(walk, "walk.bvh")


def assert_same(found: Motion, truth: Motion, atol: float = 1e-9) -> None:
    """The same motion, joints in whatever order."""
    a, b = found.skeleton, truth.skeleton
    assert sorted(a.names) == sorted(b.names)
    order = [a.names.index(name) for name in b.names]
    np.testing.assert_allclose(found.positions, truth.positions, atol=atol)
    np.testing.assert_allclose(a.offsets[order], b.offsets, atol=atol)
    np.testing.assert_allclose(a.tips[order], b.tips, atol=atol)
    assert [a.roles[joint] for joint in order] == list(b.roles)
    np.testing.assert_allclose(
        np.abs(np.sum(found.rotations[:, order] * truth.rotations, axis=-1)), 1.0, atol=atol
    )


def placed(bvh: BvhFile, shift: tuple[float, float, float]) -> BvhFile:
    values = bvh.values.copy()
    values[:, :3] += shift
    return replace(bvh, values=values)


def test_what_is_exported_is_read_back(walk: Motion, file: BvhFile, tmp_path: Path):
    write_bvh(tmp_path / "walk.bvh", file)
    take = load_take(tmp_path / "walk.bvh")
    assert_same(take.motion, walk)
    assert take.name == "walk"
    assert take.file == str(tmp_path / "walk.bvh")
    assert take.motion.fps == walk.fps
    assert take.doubts == ()
    assert list(take.found)[:3] == ["joint names", "unit", "up axis"]
    assert take.found["up axis"] == "Y"
    assert take.found["T-pose"] == "from the file's zero pose"
    assert take.found["hips forward"].startswith("+Z of the unturned hips")


@pytest.mark.parametrize(("unit", "scale"), [("m", 0.01), ("mm", 10.0), ("in", 1 / 2.54), ("cm", 1.0)])
def test_units(walk: Motion, file: BvhFile, unit: str, scale: float):
    values = file.values.copy()
    values[:, :3] *= scale
    scaled = replace(file, values=values, offsets=file.offsets * scale, end_sites=file.end_sites * scale)
    take = take_from_bvh(scaled)
    assert take.found["unit"].startswith(unit)
    assert_same(take.motion, walk)


@pytest.mark.parametrize("size", [0.62, 0.8, 1.25])
def test_small_and_tall_people_keep_their_size(walk: Motion, file: BvhFile, size: float):
    values = file.values.copy()
    values[:, :3] *= size
    take = take_from_bvh(replace(file, values=values, offsets=file.offsets * size))
    assert take.motion.skeleton.leg_length() == pytest.approx(size * walk.skeleton.leg_length())


def test_a_giant_raises_a_doubt(file: BvhFile):
    values = file.values.copy()
    values[:, :3] *= 2.0
    take = take_from_bvh(replace(file, values=values, offsets=file.offsets * 2.0))
    assert any("not an adult's size" in doubt for doubt in take.doubts)


def scaled(file: BvhFile, size: float) -> BvhFile:
    values = file.values.copy()
    values[:, :3] *= size
    return replace(file, values=values, offsets=file.offsets * size, end_sites=file.end_sites * size)


def test_answers_take_the_place_of_guesses(walk: Motion, file: BvhFile):
    giant = take_from_bvh(scaled(file, 2.0))
    (doubt,) = (doubt for doubt in giant.doubts if "tall" in doubt)
    assert "--unit" in doubt
    # a body in halves of a centimetre has no name; in inches it would be another size
    said = take_from_bvh(file, answers=TakeAnswers(unit="in", up="Y", rate=24.0))
    assert said.motion.fps == 24.0 and said.found["up axis"] == "Y, as stated"
    assert said.motion.skeleton.leg_length() == pytest.approx(2.54 * walk.skeleton.leg_length())
    assert_same(take_from_bvh(file, answers=TakeAnswers(unit="cm", up="Y")).motion, walk)


@pytest.mark.parametrize(("scale", "unit"), [(0.1, "dm"), (1.0 / 2.54, "in")])
def test_rare_units_are_doubted_and_confirmed(file: BvhFile, scale: float, unit: str):
    take = take_from_bvh(scaled(file, scale))
    assert any(f"--unit {unit}" in doubt for doubt in take.doubts)
    assert take_from_bvh(scaled(file, scale), answers=TakeAnswers(unit=unit)).doubts == ()


def test_doubts_are_errors_when_asked_for(file: BvhFile):
    assert take_from_bvh(file, answers=TakeAnswers(strict=True)).doubts == ()
    with pytest.raises(InputError, match="--strict"):
        take_from_bvh(scaled(file, 0.1), answers=TakeAnswers(strict=True))


def test_takes_that_float_are_doubted(file: BvhFile):
    up = file.channels[0].index("Yposition")
    values = file.values.copy()
    values[:, up] += 70.0
    doubts = take_from_bvh(replace(file, values=values)).doubts
    assert any("over the file's ground" in doubt and "--up" in doubt for doubt in doubts)
    values = file.values.copy()
    values[len(values) // 2 :, up] += 40.0
    doubts = take_from_bvh(replace(file, values=values)).doubts
    assert any("near the floor" in doubt for doubt in doubts)


@pytest.mark.parametrize("said", [{"unit": "ell"}, {"up": "W"}, {"rate": 0.0}, {"rate": 1e9}])
def test_answers_that_cannot_be_are_refused(tmp_path, file: BvhFile, said: dict):
    write_bvh(tmp_path / "a.bvh", file)
    with pytest.raises(InputError, match=f"--{next(iter(said))}"):
        load_take(tmp_path / "a.bvh", answers=TakeAnswers(**said))


def test_a_stated_rate_reads_a_file_whose_frame_time_is_none(tmp_path, file: BvhFile):
    write_bvh(tmp_path / "a.bvh", replace(file, frame_time=30.0))
    with pytest.raises(InputError, match="--rate 30"):
        load_take(tmp_path / "a.bvh")
    assert load_take(tmp_path / "a.bvh", answers=TakeAnswers(rate=30.0)).motion.fps == 30.0


def test_z_up_files(walk: Motion, file: BvhFile):
    """The same file turned so that Z points up: a rotation of root, offsets and all joint axes."""
    turn = quat.from_axis("X", np.pi / 2)
    values = file.values.copy()
    values[:, :3] = quat.rotate(turn, values[:, :3])
    joints = values[:, 3:].reshape(len(values), -1, 3)
    local = quat.from_euler(np.radians(joints), "YXZ")
    local = quat.multiply(quat.multiply(turn, local), quat.conjugate(turn))
    values[:, 3:] = np.degrees(quat.to_euler(local, "YXZ")).reshape(len(values), -1)
    turned = replace(
        file,
        values=values,
        offsets=quat.rotate(turn, file.offsets),
        end_sites=quat.rotate(turn, file.end_sites),
    )
    take = take_from_bvh(turned)
    assert take.found["up axis"] == "Z"
    assert_same(take.motion, walk, 1e-6)


def test_joints_above_the_hips_move_them(walk: Motion, file: BvhFile):
    """A root on the floor that carries the body, as game engines have it, changes nothing."""
    count = len(file)
    rng = np.random.default_rng(4)
    yaw = np.cumsum(rng.normal(size=count)) * 2.0
    root = np.column_stack([np.cumsum(rng.normal(size=(count, 2)), axis=0), yaw])
    back = quat.from_axis("Y", -np.radians(yaw))
    values = file.values.copy()
    place = np.column_stack([root[:, 0], np.zeros(count), root[:, 1]])
    values[:, :3] = quat.rotate(back, values[:, :3] - place)
    values[:, 3] -= yaw  # the first of the hips' YXZ angles
    rooted = replace(
        file,
        names=("Root", *file.names),
        parents=np.append(-1, file.parents + 1),
        offsets=np.concatenate([np.zeros((1, 3)), file.offsets]),
        channels=(("Xposition", "Zposition", "Yrotation"), *file.channels),
        end_parents=file.end_parents + 1,
        values=np.concatenate([root, values], axis=1),
    )
    assert_same(take_from_bvh(rooted).motion, walk)


def test_fingers_and_twist_bones_are_dropped(walk: Motion, file: BvhFile):
    wrist = file.names.index("LeftWrist")
    at = wrist + 1
    start = sum(map(len, file.channels[:at]))
    columns = np.zeros((len(file), 3))
    extra = replace(
        file,
        names=(*file.names[:at], "LeftIndex1", *file.names[at:]),
        parents=np.insert(file.parents + (file.parents > wrist), at, wrist),
        offsets=np.insert(file.offsets, at, (9.0, 1.0, 2.0), axis=0),
        channels=(*file.channels[:at], file.channels[1], *file.channels[at:]),
        end_parents=file.end_parents + (file.end_parents > wrist),
        values=np.concatenate([file.values[:, :start], columns, file.values[:, start:]], axis=1),
    )
    assert_same(take_from_bvh(extra).motion, walk)


def test_position_channels_on_other_joints(walk: Motion, file: BvhFile):
    """Constant ones are offsets, whatever OFFSET says; moving ones are told and held."""
    spine = file.names.index("Chest")
    start = sum(map(len, file.channels[:spine]))
    held = np.tile(file.offsets[spine], (len(file), 1))
    channels = list(file.channels)
    channels[spine] = ("Xposition", "Yposition", "Zposition", *channels[spine])
    offsets = file.offsets.copy()
    offsets[spine] = (50.0, 50.0, 50.0)

    def with_positions(positions: np.ndarray) -> BvhFile:
        values = np.concatenate([file.values[:, :start], positions, file.values[:, start:]], axis=1)
        return replace(file, channels=tuple(channels), offsets=offsets, values=values)

    assert_same(take_from_bvh(with_positions(held)).motion, walk)
    sliding = held.copy()
    sliding[100:110, 1] += 4.0
    take = take_from_bvh(with_positions(sliding))
    assert_same(take.motion, walk)
    assert any("Chest slides by up to 4.0 cm" in doubt for doubt in take.doubts)


def test_toes_are_made_from_the_ends_of_feet(walk: Motion, file: BvhFile):
    toes = [file.names.index(f"{side}Toe") for side in ("Left", "Right")]
    kept = [joint for joint in range(len(file.names)) if joint not in toes]
    new = {joint: at for at, joint in enumerate(kept)}
    owner = np.repeat(np.arange(len(file.names)), [len(names) for names in file.channels])
    ends = [end for end in range(len(file.end_parents)) if file.end_parents[end] not in toes]
    order = np.argsort([new[int(file.parents[toe])] for toe in toes])
    end_parents = [new[int(file.end_parents[end])] for end in ends] + [
        new[int(file.parents[toes[o]])] for o in order
    ]
    end_sites = np.concatenate([file.end_sites[ends], file.offsets[toes][order]])
    by_parent = np.argsort(end_parents)
    footless = replace(
        file,
        names=tuple(file.names[joint] for joint in kept),
        parents=np.array([new.get(int(file.parents[joint]), -1) for joint in kept]),
        offsets=file.offsets[kept],
        channels=tuple(file.channels[joint] for joint in kept),
        end_sites=end_sites[by_parent],
        end_parents=np.array(end_parents)[by_parent],
        values=file.values[:, ~np.isin(owner, toes)],
    )
    take = take_from_bvh(footless)
    assert "LeftAnkle and RightAnkle" in take.found["toes"]
    positions, truth = take.motion.forward()[0], walk.forward()[0]
    for role in ("toe.L", "toe.R", "foot.R", "hand.L"):
        shift = positions[:, take.motion.skeleton.joint(role)] - truth[:, walk.skeleton.joint(role)]
        np.testing.assert_allclose(shift[:, :2], 0.0, atol=1e-9)
    assert take.motion.skeleton.names[take.motion.skeleton.joint("toe.L")] == "LeftToe"


@pytest.mark.parametrize(("height", "moved"), [(-97.0, True), (12.0, True), (2.0, False), (0.0, False)])
def test_floor(walk: Motion, file: BvhFile, height: float, moved: bool):
    take = take_from_bvh(placed(file, (0.0, height, 0.0)))
    assert ("moved" in take.found["floor"]) == moved
    # the feet of the procedural body stand 2 cm above its floor; of a floor that is moved only about that is known
    shift = take.motion.positions[:, 2] - walk.positions[:, 2]
    np.testing.assert_allclose(shift, -0.01 if moved else 0.01 * height, atol=1e-3 if moved else 1e-9)
    stands = take.motion.skeleton.tpose_positions()[:, 2].min()
    truth = walk.skeleton.tpose_positions()[:, 2].min()
    assert stands - truth == pytest.approx(shift[0], abs=1e-3)
    np.testing.assert_allclose(take.motion.positions[:, :2], walk.positions[:, :2], atol=1e-9)


def test_first_frame_in_tpose_is_cut(walk: Motion, file: BvhFile):
    tpose = np.zeros((1, file.values.shape[1]))
    tpose[0, 1] = 95.0
    take = take_from_bvh(replace(file, values=np.concatenate([tpose, file.values])))
    assert take.found["first frame"] == "T-pose, cut (1 frame)"
    assert_same(take.motion, walk)
    # a smooth lead out of it is cut as well
    lead = np.array([0.55, 0.8, 0.95])[:, None] * (file.values[0] - tpose[0]) + tpose[0]
    take = take_from_bvh(replace(file, values=np.concatenate([tpose, lead, file.values])))
    assert 2 <= len(file) + 4 - len(take.motion) <= 4


def test_one_frame_in_tpose_is_kept(file: BvhFile):
    values = np.zeros((1, file.values.shape[1]))
    values[0, 1] = 95.0
    take = take_from_bvh(replace(file, values=values))
    assert len(take.motion) == 1
    assert take.found["first frame"] == "T-pose"
    np.testing.assert_allclose(take.motion.rotations[..., 1:3], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("frame_time", "rate"),
    [
        (0.0333333, 30.0),
        (0.033333, 30.0),
        (0.03333334, 30.0),
        (0.0333, 30.0),
        (0.016667, 60.0),
        (0.0166667, 60.0),
        (0.0167, 60.0),
        (0.00833333, 120.0),
        (0.008333, 120.0),
        (0.0083, 120.0),
        (0.041667, 24.0),
        (0.0417, 24.0),
        (0.0416667, 24.0),
        (0.04170833, 24.0 / 1.001),
        (0.03336667, 30.0 / 1.001),
        (0.01668333, 60.0 / 1.001),
        (0.04, 25.0),
        (0.02, 50.0),
        (0.01, 100.0),
        (0.011111, 90.0),
        (0.0138889, 72.0),
        (0.004166667, 240.0),
        (1.0, 1.0),
        (0.03456, 1.0 / 0.03456),
        (1e-3, 1000.0),
        (1.0 / 60.0, 60.0),
    ],
)
def test_frame_rates(frame_time: float, rate: float):
    assert frame_rate(frame_time) == pytest.approx(rate, rel=1e-12)


def test_resampling_on_the_way_in(walk: Motion, file: BvhFile):
    take = take_from_bvh(file, fps=30.0)
    assert_same(take.motion, resample(walk, 30.0))
    assert take.motion.fps == 30.0
    assert "resampled" in take.found


def test_a_mirrored_file_raises_a_doubt(file: BvhFile, walk: Motion):
    # left and right in the names alone are swapped
    swapped = [
        name.replace("Left", "?").replace("Right", "Left").replace("?", "Right") for name in file.names
    ]
    take = take_from_bvh(replace(file, names=tuple(swapped)))
    assert any("left and right are swapped" in doubt for doubt in take.doubts)
    assert take_from_bvh(to_bvh(mirror(walk), "mirror.bvh")).doubts == ()


def test_jumps_are_told_with_their_frames(file: BvhFile):
    values = file.values.copy()
    arm = sum(map(len, file.channels[: file.names.index("LeftShoulder")]))
    values[200, arm : arm + 3] += (0.0, 60.0, 0.0)
    values[300:, 0] += 30.0
    take = take_from_bvh(replace(file, values=values))
    assert any("arms jump" in doubt and "2 frames (200, 201)" in doubt for doubt in take.doubts)
    assert any("hips jump at frame 300" in doubt for doubt in take.doubts)


def test_what_is_no_body_is_refused_with_the_files_name(file: BvhFile):
    with pytest.raises(InputError, match=r"^walk\.bvh: "):
        names = tuple(f"bone{joint}" for joint in range(len(file.names)))
        # all joints on the first: no limbs
        take_from_bvh(replace(file, names=names, parents=np.minimum(file.parents, 0)))


@pytest.mark.parametrize("joint", ["LeftElbow", "RightAnkle"])
def test_limbs_without_length_are_refused(file: BvhFile, joint: str):
    offsets = file.offsets.copy()
    offsets[file.names.index(joint)] = 0.0
    with pytest.raises(InputError, match=rf"^walk\.bvh: the bone that ends at {joint} has no length"):
        take_from_bvh(replace(file, offsets=offsets))


def test_a_body_of_no_size_is_refused(file: BvhFile):
    with pytest.raises(InputError, match="no length"):
        take_from_bvh(replace(file, offsets=np.zeros_like(file.offsets)))


def test_legs_that_start_at_one_place_are_refused(file: BvhFile):
    offsets = file.offsets.copy()
    offsets[[file.names.index("LeftHip"), file.names.index("RightHip")]] = 0.0
    with pytest.raises(InputError, match="both legs start at the same place"):
        take_from_bvh(replace(file, offsets=offsets))


def test_unlikely_rates_raise_a_doubt(file: BvhFile):
    for frame_time in (2.0, 1e-5):
        doubts = take_from_bvh(replace(file, frame_time=frame_time)).doubts
        assert any("frames per second are unlikely" in doubt for doubt in doubts)


def test_one_frame_of_a_body_whose_zero_is_no_tpose_raises_a_doubt(data: Path):
    bvh = read_bvh(data / "takes" / "lafan1" / "aiming1_subject1_walk_filtered.bvh")
    take = take_from_bvh(replace(bvh, values=bvh.values[:1]))
    assert np.isfinite(take.motion.rotations).all()
    assert any("unsure" in doubt for doubt in take.doubts)


DRIFTED = {"beatsaber_10", "beatsaber_11", "boxvr_4", "jobsimulator_1", "jobsimulator_2", "jobsimulator_3"}


def test_drifted_takes_are_told_from_sound_ones(data: Path):
    found = set()
    for path in sorted((data / "takes" / "fubot_vr").glob("*.bvh")):
        bvh = read_bvh(path)
        # every third frame is enough to see it, and quick
        thinned = replace(bvh, values=bvh.values[::3], frame_time=0.1)
        if any(doubt.startswith("drift") for doubt in take_from_bvh(thinned).doubts):
            found.add(path.stem)
    assert found == DRIFTED


def test_heads_that_look_around_are_no_drift(data: Path):
    for name in ("lafan1/obstacles4_subject2_turning_filtered.bvh", "xsens/JL_mm_run.bvh"):
        bvh = read_bvh(data / "takes" / name)
        take = take_from_bvh(replace(bvh, values=bvh.values[::6], frame_time=0.1))
        assert not any(doubt.startswith("drift") for doubt in take.doubts)


REAL = {
    # take: joint names, unit, frames kept, rate, floor moved
    "xsens/100STYLE_Neutral_ID.bvh": ("Xsens", "cm", 1200, 60, False),
    "xsens/JL_mm_tpose.bvh": ("Xsens", "cm", 1, 60, False),
    "xsens/tposes/female_161_81.bvh": ("Xsens", "m", 1, 60, False),
    "lafan1/walk1_subject1_stop.bvh": ("LAFAN1", "cm", 71, 30, False),
    "lafan1/aiming1_subject1_walk_filtered.bvh": ("LAFAN1", "cm", 85, 60, False),
    "bandai_namco/dataset-2_wave-left-hand_normal_001.bvh": ("Bandai Namco", "cm", 197, 30, False),
    "cmu/007_01.bvh": ("Character Creator", "cm", 157, 60, True),
    "cmu/007_10.bvh": ("Character Creator", "cm", 150, 60, True),
    "cmu/female-walk.bvh": ("CMU", "cm", 127, 60, False),
    "cmu/basketball/006_08.bvh": ("Character Creator", "cm", 170, 60, True),
    "cmu/dance_and_martial/salsa_25.bvh": ("Daz and Poser", "cm", 1193, 120, True),
    "fubot_vr/jobsimulator_2.bvh": ("Unity Humanoid", "m", 1682, 30, False),
}


@pytest.mark.parametrize("name", REAL)
def test_real_takes(data: Path, name: str):
    take = load_take(data / "takes" / name)
    preset, unit, frames, rate, moved = REAL[name]
    assert take.found["joint names"].startswith(preset)
    assert take.found["unit"].split()[0] == unit
    assert take.found["up axis"] == "Y"
    assert (len(take.motion), take.motion.fps) == (frames, rate)
    assert ("moved" in take.found["floor"]) == moved
    assert ("cut" in take.found.get("first frame", "")) == (name.endswith(("007_10.bvh", "salsa_25.bvh")))
    assert 0.75 < take.motion.skeleton.leg_length() < 1.0
    assert not any(doubt for doubt in take.doubts if "swapped" in doubt or "size" in doubt or "up" in doubt)
    if frames > 1:
        positions, _ = take.motion.forward()
        toes = positions[:, [take.motion.skeleton.joint("toe.L"), take.motion.skeleton.joint("toe.R")], 2]
        assert -0.03 < np.quantile(toes.min(axis=1), 0.2) < 0.06


def test_takes_of_all_kinds_are_read(data: Path):
    files = sorted((data / "takes").rglob("*.bvh"))
    assert len(files) > 150
    for path in files[::5]:
        take = load_take(path)
        assert np.isfinite(take.motion.positions).all()
        np.testing.assert_allclose(np.linalg.norm(take.motion.rotations, axis=-1), 1.0, atol=1e-9)
        assert not any("swapped" in doubt for doubt in take.doubts), path


def test_who_lies_has_left_and_right_where_they_are() -> None:
    motion = demo_motion("walk")
    # on the back with the feet up: the hips' forward points at the ceiling
    lying = quat.from_axis("X", np.full(120, np.radians(80.0)))
    rotations = motion.rotations.copy()
    rotations[-120:, 0] = quat.multiply(quat.from_yaw(2.1), quat.multiply(lying, rotations[-120:, 0]))
    mixed = replace(motion, rotations=quat.continuous(rotations))
    assert abs(toes_aside(mixed) - toes_aside(cut(motion, 0, len(motion) - 120))) < np.radians(3.0)
    assert toes_aside(cut(mixed, len(motion) - 120, len(motion))) is None
