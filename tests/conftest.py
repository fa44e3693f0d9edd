"""Fixtures for all tests: where the real takes, recordings and rigs are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

DATA = Path(os.environ.get("FOOTWORK_DATA", Path(__file__).parents[2] / "shared" / "data"))


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder with real takes, recordings and rigs; tests that need it are skipped where it is absent."""
    if not (DATA / "takes").is_dir():
        pytest.skip("no motion data beside the project (set FOOTWORK_DATA)")
    return DATA
