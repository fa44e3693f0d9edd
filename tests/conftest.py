"""Fixtures for all tests: where the real takes, recordings and rigs are."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from footwork.core.mocap.bvh import write_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.presets import VARIABLE

DATA = Path(os.environ.get("FOOTWORK_DATA", Path(__file__).parents[2] / "shared" / "data"))


@pytest.fixture(scope="session", autouse=True)
def no_own_presets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The presets of whoever runs the tests do not count."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(tmp_path_factory.mktemp("presets")))
        yield


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder with real takes, recordings and rigs; tests that need it are skipped where it is absent."""
    if not (DATA / "takes").is_dir():
        pytest.skip("no motion data beside the project (set FOOTWORK_DATA)")
    return DATA


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with procedural takes: walk, turn, sidestep, crouch and visit `.bvh`."""
    folder = tmp_path_factory.mktemp("demo")
    for seed, script in enumerate(("walk", "turn", "sidestep", "crouch", "visit")):
        write_bvh(folder / f"{script}.bvh", to_bvh(demo_motion(script, seed), script))
    return folder
