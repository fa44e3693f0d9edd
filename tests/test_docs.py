"""The examples in the documents are read as they stand."""

from __future__ import annotations

import re
from pathlib import Path

from footwork.core.mocap.families import families, read_family
from footwork.core.recording.layouts import layouts, read_layout

DOCS = Path(__file__).parents[1] / "docs"


def example(document: str, folder: Path) -> Path:
    """The one JSON file that a document shows."""
    (text,) = re.findall(r"```json\n(.*?)```", (DOCS / document).read_text("utf-8"), re.DOTALL)
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
