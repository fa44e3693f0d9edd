"""The command line as a script would use it: verbs, files, exit codes, reports."""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from footwork.cli import main
from footwork.cli.common import needing
from footwork.cli.options import InputPath, OutputFolder, OutputPath
from footwork.cli.parser import VERBS, VerbParser, make_parser
from footwork.cli.verb import Verb
from footwork.core import presets
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.mocap.takes import load_take
from footwork.core.settings import BakeSettings
from footwork.nn.predictor import shipped_predictor
from footwork.nn.weights import save_predictor

WITH_BPY = importlib.util.find_spec("bpy") is not None
ROOT = Path(__file__).parents[1]
DESIGNED = (
    *("inspect", "map", "build-database", "database-info", "starter"),
    *("train-predictor", "evaluate-predictor"),
    *("simulate-recording", "bake", "batch", "evaluate", "compare-reports"),
)
"""The verbs that scripts rely on."""


@pytest.fixture(scope="module")
def walk(demo: Path) -> Path:
    """A database of the standing demo takes."""
    target = demo / "walk.npz"
    takes = [str(demo / f"{name}.bvh") for name in ("walk", "turn", "sidestep")]
    assert main(["build-database", *takes, "-o", str(target), "--mirror", "--height-range", "0.85", "2"]) == 0
    return target


@pytest.fixture(scope="module")
def crouch(demo: Path) -> Path:
    """A database of the crouching demo take."""
    target = demo / "crouch.npz"
    assert (
        main(["build-database", str(demo / "crouch.bvh"), "-o", str(target), "--height-range", "0", "0.85"])
        == 0
    )
    return target


@pytest.fixture(scope="module")
def visit(demo: Path) -> Path:
    """The demo user's recording."""
    target = demo / "visit.csv"
    assert main(["simulate-recording", str(demo / "visit.bvh"), "-o", str(target)]) == 0
    return target


def arguments_of(verb: Verb) -> list[argparse.Action]:
    parser = VerbParser(verb=verb, prog=f"footwork {verb.name}")
    parser.add_arguments()
    return parser._actions


def test_the_table_has_every_verb_and_the_documents_name_them_all() -> None:
    names = [verb.name for verb in VERBS]
    assert names == list(DESIGNED)
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    shown = {
        name for page in pages for name in re.findall(r"\bfootwork ([a-z]+(?:-[a-z]+)*)", page.read_text())
    }
    assert set(names) <= shown
    commands = re.findall(
        r"^    footwork ([a-z-]+)", "\n".join(page.read_text() for page in pages), re.MULTILINE
    )
    assert set(commands) <= set(names)


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_every_verb_and_every_argument_has_help(verb: Verb, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([verb.name, "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert text.startswith(f"usage: footwork {verb.name} ")
    assert f"{verb.help[1:]}." in text and verb.help[0].islower()
    for argument in arguments_of(verb):
        assert argument.help, argument.dest
        assert argument.option_strings == [] or argument.option_strings[-1] in text


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_every_file_of_a_verb_is_an_argument_that_says_so(verb: Verb) -> None:
    files = {InputPath, OutputPath, OutputFolder}
    kinds = {
        argument.dest: type(argument.type("x")) if callable(argument.type) else None
        for argument in arguments_of(verb)
        if re.search(r"FILE|FOLDER|\.\w+|^TAKE$|^RECORDING$", str(argument.metavar))
    }
    assert "json" in kinds and set(kinds.values()) <= files
    # the starter motion is made from nothing
    assert InputPath in kinds.values() or verb.name == "starter"


def test_the_list_of_verbs_needs_nothing_heavy() -> None:
    script = "import sys; from footwork.cli import main; code = main(['--help']); print(*sys.modules); sys.exit(code)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=True
    )
    help_text, _, modules = done.stdout.strip().rpartition("\n")
    assert all(name in help_text for name in DESIGNED)
    assert not {"numpy", "bpy", "torch", "matplotlib"} & set(modules.split())


def test_a_missing_library_is_told_and_no_other_fault_hidden() -> None:
    for name in ("bpy", "bpy.types"):
        with pytest.raises(InputError, match="get it"), needing("bpy", "get it"):
            raise ModuleNotFoundError(name=name)
    for fault in (ModuleNotFoundError(name="bpy_extras"), ModuleNotFoundError(), ImportError(name="bpy")):
        with pytest.raises(type(fault)) as caught, needing("bpy", "get it"):
            raise fault
        assert caught.value is fault


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["bake", "r.csv", "-o", "{folder}/o.blend"], "bake writes Blender files: run it in Blender"),
        (["evaluate", "t.bvh", "--in-blender"], "--in-blender measures in Blender: run it there"),
    ],
)
def test_what_needs_blender_says_so(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    said: str,
) -> None:
    monkeypatch.setitem(sys.modules, "bpy", None)
    for module in [name for name in sys.modules if name.startswith("footwork.bridge")]:
        monkeypatch.delitem(sys.modules, module)
    assert main([*(word.format(folder=tmp_path) for word in arguments), "--database", "d.npz"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"footwork {arguments[0]}: {said}") and "install the Python module bpy" in line


def test_inspect_tells_what_was_found(demo: Path, visit: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(demo / "walk.bvh"), str(visit), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    take, recording = report["files"]
    assert "Xsens" in json.dumps(take["found"])
    assert not take["doubts"]
    assert len(recording["sha256"]) == 64


def test_inspect_knows_bone_maps_of_the_users_and_names_a_broken_one_once(
    tmp_path: Path, demo: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "presets"
    monkeypatch.setenv("FOOTWORK_PRESETS", str(folder))
    for kind in ("bone_maps", "recording_layouts"):
        (folder / kind).mkdir(parents=True)
    text = (demo / "turn.bvh").read_text()
    for name, other in {"Left": "links_", "Right": "rechts_", "Hips": "Becken", "Head": "Kopf"}.items():
        text = text.replace(f" {name}", f" {other}")
    takes = [tmp_path / "a.bvh", tmp_path / "b.bvh"]
    for take in takes:
        take.write_text(text)
    assert main(["inspect", *map(str, takes)]) == 0
    assert capsys.readouterr().out.count("names and structure, ") == 2
    shipped = json.loads((presets.SHIPPED / "bone_maps" / "xsens.json").read_text())
    joints = {**shipped["joints"], "hips": "Becken", "head": "Kopf"}
    own = {"name": "Studio", "sides": ["links_", "rechts_"], "joints": joints}
    (folder / "bone_maps" / "studio.json").write_text(json.dumps(own))
    (folder / "bone_maps" / "broken.json").write_text('{"name": "Studio",\n')
    (folder / "recording_layouts" / "broken.json").write_text("7")
    assert main(["inspect", *map(str, takes), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    report = json.loads(out)
    assert ["Studio" in take["found"]["joint names"] for take in report["files"]] == [True, True]
    assert all("broken" not in json.dumps(take) for take in report["files"])
    lines = err.splitlines()
    assert [f"doubtful: {line}" for line in report["skipped_presets"]] == lines
    assert re.search(r"bone_maps.broken\.json: line 2: broken JSON", lines[0])
    assert re.search(r"recording_layouts.broken\.json: not a recording layout", lines[1])
    assert len(lines) == 2


def test_every_fault_is_told_on_a_line_and_nothing_is_written(
    tmp_path: Path, demo: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty.bvh").write_text("")
    (tmp_path / "text.bvh").write_text("not motion capture\n")
    takes = [str(tmp_path / name) for name in ("empty.bvh", "text.bvh", "absent.bvh")]
    target = tmp_path / "db.npz"
    assert main(["build-database", str(demo / "walk.bvh"), *takes, "-o", str(target)]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert [Path(path).name in line for path, line in zip(takes, lines, strict=True)] == [True] * 3
    assert not target.exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["empty.bvh", "text.bvh"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["no-such-verb"],
        ["bake"],
        ["bake", "r.csv", "--database", "d.npz", "-o", "o.blend", "--alpha", "far"],
        ["bake", "r.csv", "--database", "d.npz", "-o", "o.blend", "--alpha", "-1"],
        ["bake", "r.csv", "--database", "d.npz", "-o", "o.txt"],
        ["database-info", "absent.npz"],
    ],
)
def test_bad_usage_and_bad_input_exit_with_two(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert capsys.readouterr().err


def test_help_names_every_control(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bake", "--help"]) == 0
    text = capsys.readouterr().out
    for item in fields(BakeSettings):
        assert "--" + item.name.replace("_", "-") in text
        assert " ".join(item.metadata["help"].split())[:30] in " ".join(text.split())


def test_defaults_of_the_flags_are_those_of_the_settings() -> None:
    options = make_parser().parse_args(["bake", "r.csv", "--database", "d.npz", "-o", "o.blend"])
    options.chosen.prepare(options)
    assert (
        BakeSettings(**{item.name: getattr(options, item.name) for item in fields(BakeSettings)})
        == BakeSettings()
    )


def test_database_info(walk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["database-info", str(walk), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert [clip["mirrored"] for clip in report["clips"]] == [False, False, False, True, True, True] or (
        sum(clip["mirrored"] for clip in report["clips"]) == 3
    )
    assert report["height_range"] == [0.85, 2.0]


def test_evaluate_measures_against_the_truth(
    demo: Path, walk: Path, crouch: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--database", str(walk), "--database", str(crouch), "--true-orientation", "--json", "-"]
    assert main(["evaluate", str(demo / "visit.bvh"), *arguments]) == 0
    (entry,) = json.loads(capsys.readouterr().out)["takes"]
    metrics = entry["metrics"]
    assert metrics["root_error_cm"]["max"] <= 30.0 + 1e-6
    assert metrics["hand_position_error_cm"]["mean"] < 1.0
    assert metrics["lower_body_mpjpe_cm"]["mean"] < 25.0


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_bake_writes_a_blend_a_bvh_and_the_report(
    tmp_path: Path, walk: Path, crouch: Path, visit: Path
) -> None:
    outputs = [tmp_path / name for name in ("baked.blend", "baked.bvh", "report.json")]
    command = [
        sys.executable,
        "-m",
        "footwork",
        "bake",
        str(visit),
        "--database",
        str(walk),
        "--database",
        str(crouch),
    ]
    command += ["-o", str(outputs[0]), "--export", str(outputs[1]), "--json", str(outputs[2])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert outputs[0].read_bytes()[:7] == b"BLENDER" or outputs[0].read_bytes()[:4] == b"\x28\xb5\x2f\xfd"
    report = json.loads(outputs[2].read_text())
    assert {"root_error_cm", "foot_skate_cm_s", "hand_position_error_cm", "transitions_per_s"} <= report[
        "metrics"
    ].keys()
    assert [(row["kind"], row["sha256"]) for row in report["inputs"]] == [
        (kind, hashlib.sha256(path.read_bytes()).hexdigest())
        for kind, path in (("recording", visit), ("database", walk), ("database", crouch))
    ]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["baked.blend", "baked.bvh", "report.json"]


LOOK = """
import bpy, json, os, sys
path = sys.argv[1]
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
if path.endswith(".fbx"):
    bpy.context.scene.render.fps = 24
    bpy.ops.import_scene.fbx(filepath=path)
elif path.endswith(".glb"):
    bpy.context.scene.render.fps = 24
    bpy.ops.import_scene.gltf(filepath=path)
else:
    bpy.ops.wm.open_mainfile(filepath=path, use_scripts=False)
scene = bpy.context.scene
rig = next(obj for obj in scene.objects if obj.type == "ARMATURE")
before = [scene.render.fps, scene.frame_start, scene.frame_end, scene.frame_current]
heads = []
first = int(rig.animation_data.action.frame_range[0])
for frame in range(first, first + 72, 7):
    scene.frame_set(frame)
    pose = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
    heads.append([list(pose.matrix_world @ bone.head) for name, bone in sorted(pose.pose.bones.items())])
door = bpy.data.objects.get("Door")
print("LOOK" + json.dumps([before, first, heads, door and list(bpy.data.images["wood"].size)]))
sys.stdout.flush()
os._exit(0)
"""


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_what_a_bake_writes_is_the_same_opened_elsewhere(tmp_path: Path, walk: Path, visit: Path) -> None:
    """A .blend keeps its rate, range, frame and textures; exports show the same animation, whole."""
    make = """
import bpy, os, sys
folder = sys.argv[1]
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
from footwork.bridge.armature import create_armature
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.fit import rig_from_skeleton
scene = bpy.context.scene
create_armature(rig_from_skeleton(demo_skeleton(), "Rig"), "Rig", scene.collection)
image = bpy.data.images.new("wood", 8, 8)
image.filepath_raw, image.file_format = os.path.join(folder, "shot", "wood.png"), "PNG"
image.save()
bpy.ops.mesh.primitive_plane_add()
bpy.context.object.name = "Door"
image.use_fake_user = True
scene.render.fps, scene.frame_start, scene.frame_end = 24, 101, 140
scene.frame_set(117)
path = os.path.join(folder, "shot", "rig.blend")
bpy.ops.wm.save_as_mainfile(filepath=path)
image.filepath = "//wood.png"
bpy.ops.wm.save_as_mainfile(filepath=path)
os._exit(0)
"""
    (tmp_path / "shot").mkdir()
    (tmp_path / "out").mkdir()
    done = subprocess.run(
        [sys.executable, "-c", make, str(tmp_path)], capture_output=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    outputs = [tmp_path / "out" / f"baked.{kind}" for kind in ("blend", "fbx", "glb", "bvh")]
    command = [sys.executable, "-m", "footwork", "bake", str(visit), "--database", str(walk), "--to", "3"]
    command += ["--rig", f"{tmp_path / 'shot' / 'rig.blend'}:Rig", "-o", str(outputs[0])]
    command += [word for path in outputs[1:] for word in ("--export", str(path))]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    found = []
    for path in outputs[:3]:
        look = [sys.executable, "-c", LOOK, str(path)]
        text = subprocess.run(look, capture_output=True, text=True, timeout=300, check=True).stdout
        found.append(json.loads(next(line for line in text.splitlines() if line.startswith("LOOK"))[4:]))
    (scene, first, blend, textured), (_, _, fbx, _), (_, _, glb, _) = found
    assert scene == [24, 101, 140, 117] and first == 101 and textured == [8, 8]
    assert np.ptp(np.array(blend), axis=0).max() > 0.3
    np.testing.assert_allclose(fbx, blend, atol=2e-3)
    np.testing.assert_allclose(glb, blend, atol=2e-3)
    bvh = load_take(outputs[3], 24.0).motion
    heads = bvh.forward()[0][::7]
    order = sorted(range(len(bvh.skeleton)), key=lambda joint: bvh.skeleton.names[joint])
    np.testing.assert_allclose(heads[: len(blend), order], blend, atol=2e-3)


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_a_judge_that_shares_no_code_finds_the_same_figures(tmp_path: Path, walk: Path, visit: Path) -> None:
    baked, report, roles = (tmp_path / name for name in ("b.blend", "r.json", "roles.json"))
    command = [sys.executable, "-m", "footwork", "bake", str(visit), "--database", str(walk), "--from", "2"]
    command += ["--to", "7", "-o", str(baked), "--json", str(report)]
    subprocess.run(command, capture_output=True, timeout=300, check=True)
    body = demo_skeleton()
    roles.write_text(json.dumps({role: body.names[body.joint(role)] for role in body.roles if role}))
    judge = [sys.executable, str(ROOT / "tools" / "judge.py"), str(baked), str(report), str(roles)]
    done = subprocess.run(judge, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0 and done.stdout.count("judged") == 3, done.stdout + done.stderr
    changed = json.loads(report.read_text())
    changed["metrics"]["nsm_skate_cm_s"]["mean"] *= 1.1
    report.write_text(json.dumps(changed))
    assert subprocess.run(judge, capture_output=True, timeout=300, check=False).returncode == 1


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_bake_ends_with_three_where_a_limit_is_passed(tmp_path: Path, walk: Path, visit: Path) -> None:
    command = [sys.executable, "-m", "footwork", "bake", str(visit), "--database", str(walk), "--to", "2"]
    command += ["-o", str(tmp_path / "b.blend"), "--json", str(tmp_path / "r.json")]
    limits = ["--fail-if", "hand_position_error_cm.mean > 50", "--fail-if", "poses_used > 2"]
    done = subprocess.run([*command, *limits], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 3, done.stderr
    assert "footwork bake: failed: poses_used > 2: it is" in done.stderr.splitlines()[-1]
    report = json.loads((tmp_path / "r.json").read_text())
    assert len(report["failed"]) == 1 and report["limits"] == limits[1::2] and report["proof"]["bone"] == ""
    assert (tmp_path / "b.blend").exists()
    done = subprocess.run([*command, *limits[:2]], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    done = subprocess.run(
        [*command, "--fail-if", "hands > 1"], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 2 and "there is no metric 'hands'" in done.stderr


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_bake_with_a_bad_rig_writes_nothing(tmp_path: Path, walk: Path, visit: Path) -> None:
    (tmp_path / "rig.fbx").write_bytes(b"no fbx")
    command = [sys.executable, "-m", "footwork", "bake", str(visit), "--database", str(walk)]
    command += ["--rig", str(tmp_path / "rig.fbx"), "-o", str(tmp_path / "baked.blend")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 2
    assert "rig.fbx" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["rig.fbx"]


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_scripts_and_drivers_of_files_from_outside_do_not_run(
    tmp_path: Path, walk: Path, visit: Path
) -> None:
    """One that runs when its file is opened, and drivers, in the file of the rig and in that of the ground."""
    make = """
import bpy, os, sys
from pathlib import Path
folder = Path(sys.argv[1])
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
def poison(obj, name):
    text = bpy.data.texts.new(name + ".py")
    text.write(f"open({str(folder / ('script-' + name))!r}, 'w')")
    text.use_module = True
    driver = obj.driver_add("hide_render").driver
    driver.expression = f"(lambda: open({str(folder / ('driver-' + name))!r}, 'w') and 0)()"
from footwork.bridge.armature import create_armature
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.fit import rig_from_skeleton
rig = create_armature(rig_from_skeleton(demo_skeleton(), "Rig"), "Rig", bpy.context.scene.collection)
poison(rig, "rig")
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "rig.blend"))
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
bpy.ops.mesh.primitive_plane_add(size=40)
bpy.context.object.name = "Stage"
poison(bpy.context.object, "ground")
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "ground.blend"))
os._exit(0)  # Blender may hang at its end once a driver has failed
"""
    done = subprocess.run(
        [sys.executable, "-c", make, str(tmp_path)], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    # a file that trusts them does run both
    trusting = "import bpy, os, sys; bpy.context.preferences.filepaths.use_scripts_auto_execute = True;"
    trusting += "bpy.ops.wm.open_mainfile(filepath=sys.argv[1], use_scripts=True); os._exit(0)"
    for name in ("rig", "ground"):
        command = [sys.executable, "-c", trusting, str(tmp_path / f"{name}.blend")]
        subprocess.run(command, capture_output=True, check=True, timeout=300)
        for kind in ("script", "driver"):
            (tmp_path / f"{kind}-{name}").unlink()
    command = [sys.executable, "-m", "footwork", "bake", str(visit), "--database", str(walk), "--to", "2"]
    command += ["--rig", f"{tmp_path / 'rig.blend'}:Rig", "--ground", f"{tmp_path / 'ground.blend'}:Stage"]
    command += ["-o", str(tmp_path / "baked.blend")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["baked.blend", "ground.blend", "rig.blend"]


def test_bake_stands_on_the_ground_of_a_blend(tmp_path: Path, walk: Path, visit: Path) -> None:
    scene = tmp_path / "set.blend"
    make = (
        "import bpy, sys; bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True);"
        "bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 0, 0.7)); bpy.context.object.name = 'Stage';"
        "bpy.ops.object.empty_add(); bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1])"
    )
    subprocess.run([sys.executable, "-c", make, str(scene)], check=True, capture_output=True, timeout=300)
    report = tmp_path / "report.json"

    def bake(ground: str, *more: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "footwork", "bake", str(visit), "--database", str(walk), "--to", "4"]
        command += ["--ground", ground, "-o", str(tmp_path / "baked.blend"), *more]
        return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)

    for spec, fault in (
        (f"{scene}:Floor", "no object or collection 'Floor' in it"),
        (f"{scene}:Empty", "Empty: it has no surface to stand on"),
        (f"{tmp_path / 'gone.blend'}:Stage", "no such file"),
    ):
        done = bake(spec)
        assert done.returncode == 2 and fault in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "baked.blend").exists()
    done = bake(f"{scene}:Stage", "--json", str(report))
    assert done.returncode == 0, done.stderr
    assert "ground" in [row["kind"] for row in json.loads(report.read_text())["inputs"]]
    look = (
        "import bpy, sys; bpy.ops.wm.open_mainfile(filepath=sys.argv[1]);"
        "rig = next(obj for obj in bpy.context.scene.objects if obj.type == 'ARMATURE');"
        "print('toe', min((rig.matrix_world @ bone.head).z for bone in rig.pose.bones), 'Stage' in bpy.data.objects)"
    )
    command = [sys.executable, "-c", look, str(tmp_path / "baked.blend")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    _, toe, stage = next(line for line in done.stdout.splitlines() if line.startswith("toe")).split()
    assert 0.7 < float(toe) < 0.75 and stage == "True"


def test_a_predictor_cannot_pass_for_the_headset(
    tmp_path: Path, demo: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "headset.npz"
    save_predictor(path, shipped_predictor("causal"))
    assert main(["evaluate-predictor", str(demo / "turn.bvh"), "--predictor", str(path), "--json", "-"]) == 0
    rows = json.loads(capsys.readouterr().out)["predictors"]
    assert list(rows) == ["headset", "hands-and-head", str(path)]
    assert rows["headset"]["doubt"] is None and rows[str(path)]["doubt"] > 0.0


def test_same_inputs_give_the_same_bytes(tmp_path: Path, demo: Path) -> None:
    targets = [tmp_path / "a" / "db.npz", tmp_path / "b" / "db.npz"]
    for target in targets:
        target.parent.mkdir()
        assert main(["build-database", str(demo / "turn.bvh"), "-o", str(target), "--mirror"]) == 0
    assert targets[0].read_bytes() == targets[1].read_bytes()
    with np.load(targets[0], allow_pickle=False) as arrays:
        assert arrays.files


def test_contacts_are_set_by_hand(tmp_path: Path, demo: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["build-database", str(demo / "turn.bvh"), str(demo / "walk.bvh"), "-o"]
    texts = ["walk:L:lifted:1.2-1.65", "turn.bvh:R:planted:13.5-"]
    options = [word for text in texts for word in ("--contact", text)]
    assert main([*command, str(tmp_path / "plain.npz")]) == 0
    assert main([*command, str(tmp_path / "edited.npz"), *options]) == 0
    assert main([*command, str(tmp_path / "no.npz"), "--contact", "walk:left:lifted:1-2"]) == 2
    assert "the foot is 'left'; write L or R" in capsys.readouterr().err
    assert main([*command, str(tmp_path / "no.npz"), *options, "--contact", "walk:L:planted:1-1.5"]) == 2
    assert "says the opposite from 1.2 s on" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["edited.npz", "plain.npz"]
    with np.load(tmp_path / "plain.npz") as plain, np.load(tmp_path / "edited.npz") as edited:
        expected = plain["contacts"].copy()
        start = int(plain["clip_starts"][1])
        expected[start + 72 : start + 99, 0] = False
        expected[13 * 60 + 30 : start, 1] = True
        assert (expected != plain["contacts"])[:, 0].any()
        np.testing.assert_array_equal(edited["contacts"], expected)
        assert json.loads(json.loads(str(edited["provenance"]))["contacts"]) == texts


def test_a_crouch_database_is_made_of_walks(
    tmp_path: Path, demo: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "crouch.npz"
    command = ["build-database", str(demo / "walk.bvh"), "-o", str(target), "--body-height"]
    for height, words in (("0.5", "0.6 to 1.06"), ("1.06", "give 1.05 or less")):
        assert main([*command, height]) == 2
        assert words in capsys.readouterr().err.splitlines()[-1]
    assert not target.exists()
    assert main([*command, "0.7"]) == 0
    assert "headset heights 0 to 0.85" in capsys.readouterr().out
    assert main(["database-info", str(target)]) == 0
    assert "body height      0.7" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["build-database", "{take}", "-o", "{take}"], "ends? in .npz"),
        (["build-database", "{take}", "-o", "{folder}/db.npz", "--json", "{take}"], "files to read"),
        (["build-database", "{take}", "-o", "{folder}/none/db.npz"], "no folder"),
        (
            ["build-database", "{take}", "-o", "{folder}/db.npz", "--json", "{folder}/none/r.json"],
            "no folder",
        ),
        (["build-database", "{take}", "-o", "{folder}/db.npz", "--json", "{folder}/db.npz"], "written twice"),
        (["train-predictor", "{take}", "-o", "{folder}/none/p.npz"], "no folder"),
        (["simulate-recording", "{take}", "-o", "{folder}/r.bvh"], "end in .csv"),
        (["inspect", "{take}", "--json", "{take}"], "files to read"),
    ],
)
def test_outputs_are_checked_before_any_work(
    tmp_path: Path, demo: Path, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    take = tmp_path / "take.bvh"
    shutil.copy(demo / "turn.bvh", take)
    assert main([item.format(take=take, folder=tmp_path) for item in arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(said, line)
    assert [path.name for path in tmp_path.iterdir()] == ["take.bvh"]
    assert take.read_bytes() == (demo / "turn.bvh").read_bytes()


@pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="torch is not installed")
def test_a_cancelled_training_says_how_to_go_on(
    tmp_path: Path, demo: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "p.npz"
    takes = [str(demo / f"{name}.bvh") for name in ("walk", "turn", "visit")]
    command = ["train-predictor", *takes, "-o", str(target), "--kind", "paper", "--iterations", "2"]

    def press_ctrl_c(job, at: int):
        for _ in range(at):
            next(job)
        raise KeyboardInterrupt

    def last_line(at: int) -> str:
        with monkeypatch.context() as patch:
            patch.setattr("footwork.cli.predictor.run", lambda job: press_ctrl_c(job, at))
            assert main([*command, "--keep-worse"]) == 2
        return capsys.readouterr().err.splitlines()[-1]

    assert last_line(1) == "footwork train-predictor: cancelled"
    assert (
        last_line(3) == f"footwork train-predictor: cancelled; add --resume to go on from {target}.training"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["p.npz.training"]
    assert main([*command, "--resume", "--epochs", "3"]) == 2
    assert "differs in epochs (was 0, now 3)" in capsys.readouterr().err
    assert main([*command, "--keep-worse", "--resume"]) == 0
    assert "going on after step" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["p.npz"]


def test_a_take_given_twice_is_doubted(demo: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    again = tmp_path / "renamed.bvh"
    again.write_bytes((demo / "walk.bvh").read_bytes())
    takes = [str(demo / "walk.bvh"), str(demo / "turn.bvh"), str(again)]
    assert main(["build-database", *takes, "-o", str(tmp_path / "twice.npz")]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if "counts twice" in line]
    assert len(lines) == 1 and "renamed.bvh" in lines[0] and "walk.bvh" in lines[0]


def test_a_bone_map_on_the_command_line(
    tmp_path: Path, demo: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (demo / "turn.bvh").read_text()
    for name, other in {"Left": "links_", "Right": "rechts_", "Hips": "Becken", "Head": "Kopf"}.items():
        text = text.replace(f" {name}", f" {other}")
    (tmp_path / "a.bvh").write_text(text)
    shipped = json.loads((presets.SHIPPED / "bone_maps" / "xsens.json").read_text())
    joints = {**shipped["joints"], "hips": "Becken", "head": "Kopf"}
    own = {"name": "On the line", "sides": ["links_", "rechts_"], "joints": joints}
    (tmp_path / "map.json").write_text(json.dumps(own))
    words = ["inspect", str(tmp_path / "a.bvh"), "--bone-map", str(tmp_path / "map.json")]
    assert main(words) == 0
    assert "On the line, " in capsys.readouterr().out
    assert main(words[:2]) == 0
    assert "On the line, " not in capsys.readouterr().out
    (tmp_path / "map.json").write_text("{")
    assert main(words) == 2
    assert "map.json" in capsys.readouterr().err
