"""Searches and foot plans by name: what ships can be loaded, and a new one needs its entry and its function alone."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import fields, replace

import numpy as np
import pytest
from footwork.cli.options import add_settings, read_settings
from footwork.core.body.edit import cut
from footwork.core.body.toes import toe_positions
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.errors import InputError
from footwork.core.evaluation.study import as_paper
from footwork.core.jobs import run
from footwork.core.matching.schedule import Schedule
from footwork.core.methods import FOOT_PLANS, SEARCHES, Method, Methods
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.pipeline import bake
from footwork.core.recording.body_estimate import BodyEstimate
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig.feet import FootPlan, plant_feet
from footwork.core.settings import BAKE_PRESETS, PAPER, BakeSettings, DatabaseSettings, check

USER = cut(demo_motion("visit", 5), 60, 400)


@pytest.fixture(scope="module")
def database() -> MotionDatabase:
    take = Take("walk", "walk.bvh", "", demo_motion("walk", 1), {}, ())
    return run(build_database([take], DatabaseSettings(), name="walk"))


@pytest.fixture
def toy() -> Iterator[Callable[[Methods, Method], None]]:
    """Adds a method, and takes it away again."""
    added: list[tuple[Methods, str]] = []

    def add(methods: Methods, method: Method) -> None:
        methods.add(method)
        added.append((methods, method.name))

    yield add
    for methods, name in added:
        methods.remove(name)


def facing_north(recording: Recording) -> BodyEstimate:
    return BodyEstimate(np.zeros(len(recording)), None)


@pytest.mark.parametrize("methods", [SEARCHES, FOOT_PLANS])
def test_all_methods_can_be_loaded(methods: Methods) -> None:
    assert len(methods) >= 2
    for name, text in methods.items():
        assert callable(methods.function(name))
        assert text and not text.endswith(".")


def test_a_toy_search_needs_its_entry_alone(database: MotionDatabase, toy) -> None:
    def second_by_second(trajectory, wanted, databases, settings):
        times = np.arange(0, len(trajectory) - 1, 60)
        yield 0.5, "Toying"
        return Schedule(times, 7 + 3 * times, np.arange(len(times)) > 0)

    with pytest.raises(InputError, match="toy"):
        check(BakeSettings(search="toy"))
    toy(SEARCHES, Method("toy", "Plays on from every third frame", second_by_second))
    settings = BakeSettings(search="toy")
    recording = simulate_recording(USER, "user")
    result = run(bake(recording, [database], facing_north, None, settings))
    frames = np.arange(len(USER))
    start = np.minimum(frames // 60 * 60, (len(USER) - 2) // 60 * 60)
    np.testing.assert_array_equal(result.playback.frame, 7 + 3 * start + frames - start)
    assert result.playback.transitions.tolist() == list(range(60, len(USER) - 1, 60))
    away = np.linalg.norm(result.playback.root_positions - result.playback.target_positions, axis=-1)
    scale = result.report["scale"]
    assert away.max() <= settings.alpha * scale["user_to_database"] / scale["user_to_rig"] + 1e-9
    assert result.report["settings"]["search"] == "toy"


def test_a_toy_foot_plan_needs_its_entry_alone(database: MotionDatabase, toy) -> None:
    def hopping(motion, contacts, settings, body) -> FootPlan:
        plan = plant_feet(motion, contacts, settings, body)
        return replace(plan, toes=plan.toes + np.array([0.0, 0.0, 0.07]))

    toy(FOOT_PLANS, Method("hopping", "Never on the ground", hopping))
    recording = simulate_recording(USER, "user")
    heights = [
        toe_positions(
            run(bake(recording, [database], facing_north, None, BakeSettings(feet=feet, head=False))).motion
        )[..., 2]
        for feet in ("planted", "hopping")
    ]
    np.testing.assert_allclose(heights[1], heights[0] + 0.07, atol=5e-3)


def test_a_toy_is_a_choice_on_the_command_line(toy) -> None:
    toy(SEARCHES, Method("toy", "Nothing but a toy", lambda *_: None))
    parser = argparse.ArgumentParser()
    add_settings(parser, BakeSettings)
    assert "Nothing but a toy" in parser.format_help().replace("\n", " ")
    assert read_settings(parser.parse_args(["--search", "toy"]), BakeSettings).search == "toy"


def test_presets_name_settings_within_their_bounds() -> None:
    names = {item.name for item in fields(BakeSettings)}
    for changes in BAKE_PRESETS.values():
        assert set(changes) <= names
        check(replace(BakeSettings(), **changes))
    assert BAKE_PRESETS["As in the Paper"] is PAPER


def test_the_papers_search_is_judged_with_nothing_after_it() -> None:
    settings = as_paper(BakeSettings(alpha=0.17, halflife=0.3))
    assert {name: getattr(settings, name) for name in PAPER} == dict(PAPER)
    assert (settings.search, settings.trajectory, settings.target) == ("greedy", "causal", "head")
    assert (settings.head, settings.arms, settings.feet) == (False, False, "matched")
    assert (settings.alpha, settings.halflife) == (0.17, 0.3)
