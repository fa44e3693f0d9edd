"""`starter`, and a bake that names no database."""

from __future__ import annotations

import json
from pathlib import Path

from footwork.cli import main
from footwork.core.mocap.takes import load_take
from footwork.nn.motion.starter import RECIPES
from footwork.nn.motion.takes import SCRIPTS


def test_starter_writes_takes_and_databases_that_the_readers_take(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "starter"
    assert main(["starter", "-o", str(folder), "--json", str(tmp_path / "r.json")]) == 0
    report = json.loads((tmp_path / "r.json").read_text())
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        [
            "example.csv",
            *(f"{name}.bvh" for name, *_ in SCRIPTS),
            *(f"{recipe.name}.npz" for recipe in RECIPES),
        ]
    )
    take = load_take(folder / "side_steps.bvh")
    assert take.doubts == ()
    assert take.motion.fps == 60.0
    assert main(["database-info", str(folder / "starter_upright.npz")]) == 0
    assert {take["licence"].split(",")[0] for take in report["model"]["takes"]} == {"MIT", "CC BY 4.0"}


def test_a_bake_without_a_database_uses_the_starter_motion_and_can_be_repeated(
    demo: Path, tmp_path: Path
) -> None:
    recording, out = tmp_path / "r.csv", tmp_path / "o.npz"
    assert main(["simulate-recording", str(demo / "visit.bvh"), "-o", str(recording)]) == 0
    assert main(["bake", str(recording), "-o", str(out), "--json", str(tmp_path / "r.json")]) == 0
    report = json.loads((tmp_path / "r.json").read_text())
    used = [item["name"] for item in report["inputs"] if item["kind"] == "database"]
    assert used == [recipe.name for recipe in RECIPES]
    again = tmp_path / "again.npz"
    assert main(["bake", "--settings", str(tmp_path / "r.json"), "-o", str(again)]) == 0
    assert again.read_bytes() == out.read_bytes()
