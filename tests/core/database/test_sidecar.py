from __future__ import annotations

import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.database.motion_database import FeatureDatabase, MotionDatabase, PoseDatabase
from footwork.core.database.schema import LAYOUT
from footwork.core.database.sidecar import load_database, save_database
from footwork.core.errors import InputError
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

Arrays = dict[str, Any]


@pytest.fixture(scope="session")
def saved(small: MotionDatabase, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("databases") / "small.npz"
    save_database(path, small)
    return path


def arrays_of(path: Path) -> Arrays:
    with np.load(path, allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def fault(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        load_database(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert "\n" not in text
    return text


def test_round_trip_is_exact(small: MotionDatabase, saved: Path) -> None:
    loaded = load_database(saved)
    for part, kind in (("poses", PoseDatabase), ("features", FeatureDatabase)):
        for item in fields(kind):
            before = getattr(getattr(small, part), item.name)
            after = getattr(getattr(loaded, part), item.name)
            np.testing.assert_array_equal(after, before)
            assert after.dtype == before.dtype
    for name in ("name", "fps", "clips", "head_height", "height_range", "tags", "provenance"):
        assert getattr(loaded, name) == getattr(small, name)
    for name in ("names", "roles"):
        assert getattr(loaded.skeleton, name) == getattr(small.skeleton, name)
    for name in ("parents", "offsets", "tips"):
        np.testing.assert_array_equal(getattr(loaded.skeleton, name), getattr(small.skeleton, name))


def test_same_database_same_bytes(small: MotionDatabase, saved: Path, tmp_path: Path) -> None:
    save_database(tmp_path / "again.npz", small)
    save_database(tmp_path / "loaded.npz", load_database(saved))
    assert (tmp_path / "again.npz").read_bytes() == saved.read_bytes()
    assert (tmp_path / "loaded.npz").read_bytes() == saved.read_bytes()


def test_numpy_alone_reads_it(small: MotionDatabase, saved: Path) -> None:
    arrays = arrays_of(saved)
    assert set(arrays) == {"format", "schema", "producer", *LAYOUT}
    assert str(arrays["format"]) == "footwork-motion-database"
    assert int(arrays["schema"]) == 2
    assert arrays["rotations"].dtype == np.float32
    assert arrays["features"].dtype == np.float32
    assert arrays["tags"].tolist() == list(small.tags)


def test_the_manual_names_every_array() -> None:
    manual = Path(__file__).parents[3] / "docs" / "database-format.md"
    text = manual.read_text("utf-8")
    assert [name for name in ("format", "schema", "producer", *LAYOUT) if f"`{name}`" not in text] == []


def test_files_of_the_first_schema_still_load(small: MotionDatabase, saved: Path, tmp_path: Path) -> None:
    arrays = arrays_of(saved)
    arrays["schema"], arrays["eye_height"] = np.array(1), np.array(1.375)
    del arrays["head_height"]
    np.savez(tmp_path / "old.npz", **arrays)
    old = load_database(tmp_path / "old.npz")
    assert old.head_height == 1.375
    np.testing.assert_array_equal(old.poses.rotations, load_database(saved).poses.rotations)
    # what a name means goes by the schema
    arrays["schema"] = np.array(2)
    np.savez(tmp_path / "mixed.npz", **arrays)
    assert "no array 'head_height'" in fault(tmp_path / "mixed.npz")


def test_no_tags_and_unknown_arrays(saved: Path, tmp_path: Path) -> None:
    arrays = arrays_of(saved)
    np.savez(tmp_path / "a.npz", **(arrays | {"tags": np.array([], dtype="U1"), "extra": np.zeros(3)}))
    assert load_database(tmp_path / "a.npz").tags == ()


def test_big_endian_and_double_files_are_read(saved: Path, tmp_path: Path) -> None:
    arrays = arrays_of(saved)
    arrays["rotations"] = arrays["rotations"].astype(">f8")
    arrays["clip_starts"] = arrays["clip_starts"].astype(">i2")
    np.savez_compressed(tmp_path / "a.npz", **arrays)
    np.testing.assert_array_equal(load_database(tmp_path / "a.npz").poses.rotations, arrays["rotations"])


@pytest.mark.parametrize("name", LAYOUT)
def test_missing_array(saved: Path, tmp_path: Path, name: str) -> None:
    arrays = arrays_of(saved)
    del arrays[name]
    np.savez(tmp_path / "a.npz", **arrays)
    assert repr(name) in fault(tmp_path / "a.npz")


@pytest.mark.parametrize("name", [name for name, (_, shape) in LAYOUT.items() if shape and shape != ("K",)])
def test_wrong_shape(saved: Path, tmp_path: Path, name: str) -> None:
    whole = arrays_of(saved)
    for change in (lambda a: a[:-1], lambda a: a[None], lambda a: np.concatenate([a, a[-1:]])):
        np.savez(tmp_path / "a.npz", **(whole | {name: change(whole[name])}))
        fault(tmp_path / "a.npz")


@pytest.mark.parametrize("name", [name for name, (kind, _) in LAYOUT.items() if kind.startswith("f")])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_finite(saved: Path, tmp_path: Path, name: str, value: float) -> None:
    arrays = arrays_of(saved)
    arrays[name].reshape(-1)[-1:] = value
    np.savez(tmp_path / "a.npz", **arrays)
    assert f"{name!r} holds numbers that are not finite" in fault(tmp_path / "a.npz")


def put(name: str, index: Any, value: Any):
    def change(arrays: Arrays) -> None:
        arrays[name][index] = value

    return change


def times(name: str, factor: float):
    def change(arrays: Arrays) -> None:
        arrays[name] = arrays[name] * np.asarray(factor, arrays[name].dtype)

    return change


def swap(name: str, value: Any):
    def change(arrays: Arrays) -> None:
        arrays[name] = np.array(value)

    return change


FAULTS = {
    "newer schema": (swap("schema", 3), "comes from a newer Footwork (schema 3, here 2); update"),
    "schema text": (swap("schema", "one"), "schema is no number"),
    "other format": (swap("format", "footwork-predictor"), "'footwork-predictor', no motion database"),
    "texts for numbers": (swap("fps", "60"), "'fps' holds <U2"),
    "fps": (swap("fps", 0.0), "'fps' is 0"),
    "head height": (swap("head_height", -1.0), "'head_height'"),
    "height range": (swap("height_range", [1.0, 0.5]), "1 to 0.5 is empty"),
    "no unit": (put("rotations", (5, 3), [2.0, 0.0, 0.0, 0.0]), "unit length"),
    "parents order": (put("joint_parents", 4, 9), "no hierarchy"),
    "two hips": (put("joint_parents", 1, -1), "no hierarchy"),
    "role unknown": (put("joint_roles", 1, "tail"), "'tail'"),
    "role twice": (put("joint_roles", 1, "chest"), "'chest'"),
    "role missing": (put("joint_roles", 6, ""), "role 'head'"),
    "hips first": (put("joint_roles", 0, ""), "first joint"),
    "broken leg": (put("joint_parents", 12, 0), "thigh, shin, foot, toe (L) do not follow each other"),
    "loose clavicle": (put("joint_parents", 16, 4), "clavicle, upper_arm, forearm, hand (R) do not follow"),
    "loose toe": (put("joint_parents", 22, 20), "thigh, shin, foot, toe (R) do not follow each other"),
    "no leg": (put("joint_offsets", 12, 0.0), "without length"),
    "gap in clips": (put("clip_starts", 1, 841), "clip table"),
    "backward clip": (put("clip_stops", 0, 0), "clip table"),
    "clips too short": (put("clip_stops", -1, 3419), "clip table"),
    "found at an end": (put("trajectory_valid", 839, True), "'trajectory_valid'"),
    "nothing found": (put("trajectory_valid", slice(None), False), "'trajectory_valid'"),
    "deviation": (put("feature_deviation", 3, 0.0), "'feature_deviation'"),
    "layout": (put("feature_starts", 1, 7), "laid out"),
    "horizons": (put("feature_horizons", 1, 0.5), "laid out"),
    "giant": (swap("head_height", 1e300), "'head_height' is 1e+300 m"),
    "dwarf": (swap("head_height", 0.05), "'head_height' is 0.05 m"),
    "long bones": (times("joint_offsets", 1e6), "'joint_offsets' holds"),
    "far roots": (times("root_positions", 1e9), "'root_positions' holds"),
    "fast hips": (times("hips_velocities", 1e9), "'hips_velocities' holds"),
    "fast turns": (put("angular_velocities", (5, 3), 1e3), "'angular_velocities' holds"),
    "features of nothing": (times("features", 0.0), "not those of its poses"),
    "features of others": (lambda a: a.update(features=a["features"][::-1].copy()), "not those of its poses"),
    "features of giants": (times("features", 1e9), "'features' holds"),
    "provenance deep": (swap("provenance", "[" * 5000), "'provenance'"),
    "provenance": (swap("provenance", "[1]"), "'provenance'"),
    "provenance cut": (swap("provenance", '{"a": '), "'provenance'"),
}


@pytest.mark.parametrize("case", FAULTS)
def test_faults(saved: Path, tmp_path: Path, case: str) -> None:
    change, words = FAULTS[case]
    arrays = arrays_of(saved)
    change(arrays)
    np.savez(tmp_path / "a.npz", **arrays)
    said = fault(tmp_path / "a.npz")
    assert words in said
    assert said.count("a.npz") == 1 and said.count("; ") == 1


def test_no_npz(tmp_path: Path) -> None:
    assert "no such file" in fault(tmp_path / "missing.npz")
    assert "cannot be read" in fault(tmp_path)
    path = tmp_path / "a.npz"
    for content in (b"", b"HIERARCHY\nROOT Hips", b"PK\x03\x04", np.random.default_rng(1).bytes(3000)):
        path.write_bytes(content)
        assert "no .npz file" in fault(path)
    np.save(tmp_path / "b.npy", np.zeros(3))
    assert "no .npz file" in fault(tmp_path / "b.npy")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "hello")
    assert "no motion database" in fault(path)


def test_pickles_are_refused(saved: Path, tmp_path: Path) -> None:
    arrays = arrays_of(saved)
    arrays["name"] = np.array({"a": 1}, dtype=object)
    np.savez(tmp_path / "a.npz", **arrays)
    assert "cannot be read" in fault(tmp_path / "a.npz")


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(share=st.floats(0.0, 0.999999))
def test_cut_short(saved: Path, tmp_path: Path, share: float) -> None:
    content = saved.read_bytes()
    (tmp_path / "a.npz").write_bytes(content[: int(share * len(content))])
    fault(tmp_path / "a.npz")


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.floats(0.0, 1.0, exclude_max=True), from_end=st.booleans(), bit=st.integers(0, 7))
def test_flipped_bits_never_pass_for_other_numbers(
    small: MotionDatabase, saved: Path, tmp_path: Path, place: float, from_end: bool, bit: int
) -> None:
    content = bytearray(saved.read_bytes())
    # the directory of the zip lies in the last few thousand bytes
    span = 4000 if from_end else len(content)
    content[len(content) - 1 - int(place * span)] ^= 1 << bit
    path = tmp_path / "a.npz"
    path.write_bytes(content)
    try:
        loaded = load_database(path)
    except InputError as error:
        assert "\n" not in str(error)
        assert str(error).startswith(f"{path}: ")
    else:
        # a bit of a date or a comment: nothing that is read
        np.testing.assert_array_equal(loaded.poses.rotations, small.poses.rotations)
        np.testing.assert_array_equal(loaded.features.values, small.features.values)
        assert loaded.clips == small.clips
