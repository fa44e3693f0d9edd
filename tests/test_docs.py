"""The examples in the documents are read as they stand."""

from __future__ import annotations

import ast
import re
import sys
import textwrap
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.database.build import build_database
from footwork.core.jobs import run
from footwork.core.matching import greedy_search
from footwork.core.measure import root
from footwork.core.measure.catalogue import METRICS
from footwork.core.methods import FOOT_PLANS, SEARCHES, Method
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.families import families, read_family
from footwork.core.mocap.take import Take
from footwork.core.pipeline import bake
from footwork.core.recording.body_estimate import BodyEstimate
from footwork.core.recording.layouts import layouts, read_layout
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig import feet
from footwork.core.settings import BakeSettings, DatabaseSettings, check

DOCS = Path(__file__).parents[1] / "docs"


def blocks(document: str, language: str) -> list[str]:
    """What a document shows in a language."""
    found = re.findall(rf"```{language}\n(.*?)```", (DOCS / document).read_text("utf-8"), re.DOTALL)
    return [textwrap.dedent(text) for text in found]


def module_of(function: str, beside: ModuleType) -> tuple[ModuleType, Any]:
    """The example of contributing.md that defines a function, as a module beside another one, and its entry."""
    (text,) = (text for text in blocks("contributing.md", "python") if f"def {function}(" in text)
    *body, entry = ast.parse(text).body
    module = ModuleType("example")
    vars(module).update({**vars(beside), "replace": replace, "np": np, "Method": Method})
    exec(compile(ast.Module(body, []), "contributing.md", "exec"), vars(module))
    return module, eval(compile(ast.Expression(entry.value), "contributing.md", "eval"), vars(module))


def example(document: str, folder: Path) -> Path:
    """The one JSON file that a document shows."""
    (text,) = blocks(document, "json")
    path = folder / "example.json"
    path.write_text(text, "utf-8")
    return path


def test_the_example_of_a_bone_map(tmp_path: Path) -> None:
    family = read_family(example("takes.md", tmp_path))
    assert family.names["shin.R"] == ("rechtsunterschenkel",)
    assert family.name not in {other.name for other in families().entries}


def test_the_example_of_a_recording_layout(tmp_path: Path) -> None:
    layout = read_layout(example("recording-format.md", tmp_path))
    assert layout.columns[:4] == ("timestamp", "hx", "hy", "hz")
    assert layout.name not in {other.name for other in layouts().entries}


def test_the_json_examples_of_contributing(tmp_path: Path) -> None:
    for text, read in zip(blocks("contributing.md", "json"), (read_layout, read_family), strict=True):
        (tmp_path / "toy.json").write_text(text, "utf-8")
        assert read(tmp_path / "toy.json").name.startswith("Toy")


def test_the_code_of_contributing_is_python() -> None:
    texts = blocks("contributing.md", "python")
    assert len(texts) >= 9
    for text in texts:
        ast.parse(text)


def test_the_examples_of_a_search_a_foot_plan_and_a_metric(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each works as it stands, once its entry is made."""
    for methods, function, beside in (
        (SEARCHES, "find_first", greedy_search),
        (FOOT_PLANS, "float_feet", feet),
    ):
        module, entry = module_of(function, beside)
        monkeypatch.setitem(sys.modules, f"footwork.core.{entry.function.partition(':')[0]}", module)
        monkeypatch.setattr(methods, "_methods", dict(methods._methods))
        methods.add(entry)
    (metric,) = module_of("_above_hips", root)[1]
    monkeypatch.setitem(METRICS, metric.name, metric)
    take = Take("walk", "walk.bvh", "", demo_motion("walk", 1), {}, ())
    databases = [run(build_database([take], DatabaseSettings(), name="walk"))]
    user = simulate_recording(cut(demo_motion("visit", 5), 60, 300), "user")
    settings = BakeSettings(search="first", feet="floating", head=False)
    check(settings)
    result = run(bake(user, databases, lambda _: BodyEstimate(np.zeros(len(user)), None), None, settings))
    assert result.playback.frame[:119].tolist() == [*range(60), *range(59)]
    assert 40.0 < result.report["metrics"]["head_above_hips_cm"]["mean"] < 80.0
    grounded = run(
        bake(
            user,
            databases,
            lambda _: BodyEstimate(np.zeros(len(user)), None),
            None,
            BakeSettings(search="first"),
        )
    )
    higher = [made.motion.forward()[0][..., 2].min(axis=1).mean() for made in (result, grounded)]
    assert higher[0] - higher[1] == pytest.approx(0.1, abs=0.01)
