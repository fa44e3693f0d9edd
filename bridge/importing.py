"""Takes and animated objects from files that Blender opens, in a process of its own that hands the poses over."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.errors import InputError
from ..core.files import sha256_of
from ..core.mocap.bvh import BvhFile
from ..core.mocap.poses import bvh_of_poses
from ..core.recording.raw import Extra, RawRecording, Reading, Track
from ..core.recording.read import to_recording
from ..core.recording.reading.answers import NO_ANSWERS, Answers
from ..core.recording.recording import TRACKERS, Recording

_PACKAGE = Path(__file__).resolve().parents[1]
_LONGEST_S = 1800.0
_WORK = """
import importlib.util, os, sys
folder, path, into = sys.argv[-3:]
spec = importlib.util.spec_from_file_location(
    "footwork", os.path.join(folder, "__init__.py"), submodule_search_locations=[folder])
sys.modules["footwork"] = module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
from footwork.bridge.MODULE import write_poses
write_poses(path, into)
# some Blenders crash while Python tears them down
os._exit(0)
"""


def read_scene_take(path: str) -> BvhFile:
    """A take from an FBX or glTF file, in metres and Blender's axes, every bone a joint that rests as bound.

    Raises:
        InputError: Blender cannot read the file, or there is not one moving skeleton in it.
    """
    path = str(Path(path).resolve())
    with tempfile.TemporaryDirectory(prefix="footwork-") as folder:
        found = _in_own_blender(path, folder, "scene_takes")
        with np.load(Path(folder) / "poses.npz", allow_pickle=False) as poses:
            return bvh_of_poses(
                found["names"],
                poses["parents"],
                poses["rest"],
                poses["positions"],
                poses["rotations"],
                fps=found["fps"],
                file=path,
                sha256=sha256_of(path),
                rest_is_a_frame=found["rest_is_a_frame"],
                doubts=found["doubts"],
            )


def read_scene_recording(path: str, answers: Answers = NO_ANSWERS) -> Recording:
    """The recording that three or more animated objects of a .blend, FBX or glTF file give, told apart by their names.

    Raises:
        InputError: Blender cannot read the file, or no object in it that moves is called a head or a headset.
    """
    full = str(Path(path).resolve())
    with tempfile.TemporaryDirectory(prefix="footwork-") as folder:
        found = _in_own_blender(full, folder, "scene_objects")
        with np.load(Path(folder) / "poses.npz", allow_pickle=False) as poses:
            times, positions, rotations = poses["times"], poses["positions"], poses["rotations"]
    tracks = {
        name: Track(times, positions[:, place], rotations[:, place], np.ones(len(times), np.bool_))
        for place, name in enumerate(found["trackers"])
    }
    none = Track(times[:0], np.empty((0, 3)), np.empty((0, 4)), np.empty(0, np.bool_))
    head, left, right = (tracks.get(name, none) for name in TRACKERS)
    raw = RawRecording(
        tracks=(head, left, right),
        found={"format": "objects of a scene", "objects": ", ".join(found["names"])},
        name=Path(path).stem,
        # where these are not the axes of devices, the movement tells others
        reading=Reading(axes="RFU"),
        stated=frozenset(("axes", "unit", "rotation", "sides")),
        extra=tuple(Extra(name, track) for name, track in tracks.items() if name not in TRACKERS),
    )
    return to_recording(raw, path, sha256_of(full), answers)


def _in_own_blender(path: str, folder: str, module: str) -> dict[str, Any]:
    """What `write_poses` of a module of this package says of a file, in a Blender of its own."""
    script = Path(folder) / "work.py"
    script.write_text(_WORK.replace("MODULE", module), encoding="utf-8")
    try:
        done = subprocess.run(
            [*_blender(str(script)), str(_PACKAGE), path, folder],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_LONGEST_S,
            check=False,
            env={**os.environ, "PYTHONUTF8": "1", "PYTHONDONTWRITEBYTECODE": "1"},
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"{path}: Blender is not done with it in half an hour; export it in parts") from None
    said = Path(folder) / "said.json"
    if not said.is_file():
        if done.returncode < 0 or b"Traceback" not in done.stderr:
            raise InputError(f"{path}: Blender's importer broke off on it; export it anew")
        raise RuntimeError(done.stderr.decode(errors="replace"))
    found: dict[str, Any] = json.loads(said.read_text(encoding="utf-8"))
    if "faults" in found:
        raise InputError(*found["faults"])
    return found


def _blender(script: str) -> list[str]:
    """The command that runs a script in another Blender like this one."""
    if getattr(bpy.app, "module", False) or not bpy.app.binary_path:
        return [sys.executable, script]
    return [bpy.app.binary_path, "--background", "--factory-startup", "--python", script, "--"]
