"""The same bake is the same to the last bit, on any number of threads."""

from __future__ import annotations

import os
import subprocess
import sys

SCRIPT = """
import dataclasses, hashlib, json
from functools import partial
from footwork.core.body.edit import cut
from footwork.core.database.build import build_database
from footwork.core.jobs import run
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from footwork.core.mocap.take import Take
from footwork.core.pipeline import bake
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig.fit import rig_from_skeleton
from footwork.core.settings import PAPER, BakeSettings, DatabaseSettings
from footwork.nn.predictor import predict, shipped_predictors

take = Take("walk", "walk.bvh", "", demo_motion("walk", 1), {}, ())
database = run(build_database([take], DatabaseSettings(), name="walk"))
recording = simulate_recording(cut(demo_motion("visit", 5, height=1.62), 60, 420), "user")
rig = rig_from_skeleton(demo_skeleton(height=1.81), "rig")
found = hashlib.sha256()
for name, predictor in shipped_predictors().items():
    for settings in (BakeSettings(), dataclasses.replace(BakeSettings(), **PAPER)):
        result = run(bake(recording, [database], partial(predict, predictor), rig, settings))
        report = {key: value for key, value in result.report.items() if not key.startswith("timing")}
        for array in (result.tracks.rotations, result.tracks.locations, result.playback.frame, result.contacts):
            found.update(array.tobytes())
        found.update(json.dumps(report, default=str, sort_keys=True).encode())
        print(name, settings.search, found.hexdigest())
"""


def test_a_bake_and_its_figures_are_the_same_on_any_number_of_threads() -> None:
    def bakes(threads: int) -> str:
        names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        environment = {**os.environ, **dict.fromkeys(names, str(threads)), "PYTHONHASHSEED": str(threads)}
        command = [sys.executable, "-c", SCRIPT]
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    one = bakes(1)
    assert len(one.splitlines()) >= 6
    assert bakes(2) == one == bakes(4)
