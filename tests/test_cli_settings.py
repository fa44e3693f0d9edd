"""Bakes without Blender, and `bake --settings`: an earlier bake repeated."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.cli import main
from footwork.cli.bake_options import read_said
from footwork.cli.baking import file_of
from footwork.core.errors import FaultError
from footwork.core.maths import quat
from footwork.core.settings import BakeSettings


@pytest.fixture(scope="module")
def made(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two databases and a recording."""
    folder = tmp_path_factory.mktemp("made")
    for name in ("turn", "walk"):
        arguments = [str(demo / f"{name}.bvh"), "-o", str(folder / f"{name}.npz")]
        assert main(["build-database", *arguments]) == 0
    assert main(["simulate-recording", str(demo / "visit.bvh"), "-o", str(folder / "r.csv")]) == 0
    return folder


def bake(made: Path, out: Path, *more: str) -> dict[str, Any]:
    """Bake tracks, and give the report."""
    report = out.with_suffix(".json")
    assert main(["bake", *more, "-o", str(out), "--json", str(report)]) == 0
    return json.loads(report.read_text())


HEADSET = ("head_px", "head_py", "head_pz")
QUICK = ("--search", "greedy", "--to", "3")


def test_tracks_need_no_blender_and_move_the_rig_as_the_headset_moved(
    tmp_path: Path, made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "bpy", None)
    for module in [name for name in sys.modules if name.startswith("footwork.bridge")]:
        monkeypatch.delitem(sys.modules, module)
    report = bake(
        made,
        tmp_path / "t.npz",
        str(made / "r.csv"),
        "--database",
        str(made / "walk.npz"),
        *QUICK,
        "--fps",
        "30",
    )
    tracks = np.load(tmp_path / "t.npz", allow_pickle=False)
    assert str(tracks["format"]) == "footwork-tracks" and float(tracks["fps"]) == 30.0
    assert report["written"]["frames"] == len(tracks["rotations"]) == 91
    # Blender's own rule: pose = parent's pose, rest relative to the parent's, then the keyed channels
    bones, rest = [str(name) for name in tracks["rig_bones"]], tracks["rig_rest"]
    keyed = {str(name): i for i, name in enumerate(tracks["bones"])}
    pose = np.zeros((91, len(bones), 4, 4))
    for bone, (name, parent) in enumerate(zip(bones, tracks["rig_parents"], strict=True)):
        local = np.zeros((91, 4, 4))
        local[:] = np.eye(4)
        if name in keyed:
            local[:, :3, :3] = quat.to_matrix(tracks["rotations"][:, keyed[name]].astype(float))
            if keyed[name] == 0:
                local[:, :3, 3] = tracks["locations"]
        placed = rest[bone] if parent < 0 else np.linalg.inv(rest[parent]) @ rest[bone]
        pose[:, bone] = (placed if parent < 0 else pose[:, parent] @ placed) @ local
    head = (tracks["rig_world"] @ pose)[:, [str(role) for role in tracks["rig_roles"]].index("head"), :3, 3]
    lines = [line for line in (made / "r.csv").read_text().splitlines() if not line.startswith("#")]
    table = list(csv.DictReader(lines))
    rows = {name: np.array([float(row[name]) for row in table]) for name in ("time", *HEADSET)}
    times = rows["time"] - rows["time"][0]
    headset = np.stack([np.interp(np.arange(91) / 30.0, times, rows[name]) for name in HEADSET], axis=-1)
    moved, should = head - head[0], headset - headset[0]
    assert np.ptp(should, axis=0).max() > 0.1
    np.testing.assert_allclose(moved, should, atol=0.06)


def test_a_report_repeats_its_bake(tmp_path: Path, made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = ("--alpha", "0.17", "--no-arms", "--from", "0.5", "--eye-height", "1.62", "--fps", "24")
    databases = ("--database", str(made / "walk.npz"), "--database", str(made / "turn.npz"))
    first = bake(made, tmp_path / "a.npz", str(made / "r.csv"), *databases, *QUICK, *said)
    capsys.readouterr()
    again = bake(made, tmp_path / "b.npz", "--settings", str(tmp_path / "a.json"))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert again["settings"] == first["settings"] and again["metrics"] == first["metrics"]
    assert again["settings"]["alpha"] == 0.17 and again["settings"]["arms"] is False
    assert again["warnings"] == first["warnings"]
    other = bake(made, tmp_path / "c.npz", "--settings", str(tmp_path / "a.json"), "--alpha", "0.3", "--arms")
    assert other["settings"] == {**first["settings"], "alpha": 0.3, "arms": True}
    assert other["options"] == first["options"] and other["warnings"][-1:] == first["warnings"][-1:]


def test_a_repetition_warns_of_another_version_and_of_changed_inputs(
    tmp_path: Path, made: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = tmp_path / "base.npz"
    base.write_bytes((made / "walk.npz").read_bytes())
    bake(made, tmp_path / "a.npz", str(made / "r.csv"), "--database", str(base), *QUICK)
    base.write_bytes((made / "turn.npz").read_bytes())
    earlier = json.loads((tmp_path / "a.json").read_text())
    earlier["producer"] = "footwork 0.0.7"
    earlier["settings"].pop("alpha")
    earlier["settings"]["foot_lock"] = True
    (tmp_path / "a.json").write_text(json.dumps(earlier))
    capsys.readouterr()
    again = bake(made, tmp_path / "b.npz", "--settings", str(tmp_path / "a.json"))
    told = [line for line in again["warnings"] if line.startswith("not the same")]
    assert "footwork 0.0.7" in told[0] and "now by footwork" in told[0]
    assert told[1].startswith("not the same: database turn has other content than walk had")
    assert "foot_lock" in told[2] and told[3].endswith("had no setting alpha") and len(told) == 4
    assert again["settings"]["alpha"] == BakeSettings().alpha
    assert all(f"footwork bake: {line}" in capsys.readouterr().err for line in told[:1])
    # an older report has settings alone
    (tmp_path / "old.json").write_text(json.dumps({"settings": {"alpha": 0.5}}))
    given = (str(made / "r.csv"), "--database", str(base), *QUICK)
    old = bake(made, tmp_path / "c.npz", *given, "--settings", str(tmp_path / "old.json"))
    assert old["settings"]["alpha"] == 0.5
    assert any("does not say what its bake was made from" in line for line in old["warnings"])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("7", "has no settings"),
        ("{", "broken JSON"),
        ('{"settings": {"alpha": "far"}}', "invalid float value"),
        ('{"settings": {"alpha": [1]}}', "no value of it"),
        ('{"settings": {"arms": 3}}', "neither true nor false"),
        ('{"settings": {}, "options": 3}', "options are none"),
        ('{"settings": {}, "options": {"output": "x"}}', "there is no option 'output'"),
        ('{"settings": {}, "recording": 3}', "no name of a file"),
        ('{"settings": {"alpha": -1}}', "alpha"),
        ('{"settings": {}}', "no recording"),
    ],
)
def test_what_is_no_report_of_a_bake_is_refused_in_a_line(
    tmp_path: Path, content: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "r.json").write_text(content)
    more = ["r.csv", "--database", "d.npz"] if '"alpha": -1' in content else []
    arguments = ["bake", *more, "--settings", str(tmp_path / "r.json"), "-o", str(tmp_path / "o.npz")]
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert [path.name for path in tmp_path.iterdir()] == ["r.json"]


def test_an_input_that_only_the_report_names_is_not_overwritten(
    tmp_path: Path, made: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = tmp_path / "base.npz"
    base.write_bytes((made / "turn.npz").read_bytes())
    before = base.read_bytes()
    report = {"settings": {}, "recording": str(made / "r.csv"), "options": {"database": [str(base)]}}
    (tmp_path / "r.json").write_text(json.dumps(report))
    assert main(["bake", "--settings", str(tmp_path / "r.json"), "-o", str(base)]) == 2
    assert "is one of the files to read" in capsys.readouterr().err
    assert base.read_bytes() == before


def test_rows_say_options_in_texts_or_values() -> None:
    assert read_said({"alpha": "0.25", "arms": "no", "swap_hands": "", "database": "a.npz; b.npz"}) == {
        "alpha": 0.25,
        "arms": False,
        "database": ["a.npz", "b.npz"],
    }
    assert read_said({"to": 7, "fit-range": True, "fail_if": ["poses_used > 3"], "strict": False}) == {
        "stop": 7.0,
        "fit_range": True,
        "fail_if": ["poses_used > 3"],
    }
    assert read_said({"eye-height": "-1"}) == {"eye_height": -1.0}
    for row in ({"speed": 3}, {"search": "slow"}, {"alpha": True}, {"database": [["a"]]}, {"feet": {"a": 1}}):
        with pytest.raises(FaultError):
            read_said(row)


def test_the_file_of_a_rig(tmp_path: Path) -> None:
    odd = tmp_path / "a:b.blend"
    odd.touch()
    for spec, file in ((str(odd), str(odd)), (f"{odd}:Hero", str(odd)), ("h.fbx", "h.fbx"), (None, None)):
        assert file_of(spec) == file
