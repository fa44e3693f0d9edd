"""The arrows between packages go one way, and the method runs without Blender and torch."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOREIGN = {
    "bpy",
    "mathutils",
    "gpu",
    "bl_ui",
    "torch",
    "scipy",
    "matplotlib",
    "optuna",
    "pymotion",
    "distributed",
}

BASE = {
    *("bounds", "errors", "files", "jobs", "json_text", "methods", "npz", "presets", "settings", "staging"),
    "transaction",
}
"""Modules of core that every part of it may use; they use each other alone."""
ARROWS: dict[str, set[str]] = {
    "core.maths": set(),
    "core.body": {"core.maths"},
    "core.mocap": {"core.body", "core.maths"},
    "core.recording": {"core.mocap", "core.body", "core.maths"},
    "core.database": {"core.recording", "core.mocap", "core.body", "core.maths"},
    "core.rig": {"core.recording", "core.mocap", "core.body", "core.maths"},
    "core.matching": {"core.database", "core.rig", "core.recording", "core.mocap", "core.body", "core.maths"},
    "core.measure": {
        *("core.matching", "core.database", "core.rig"),
        *("core.recording", "core.mocap", "core.body", "core.maths"),
    },
    "core.pipeline": {
        *("core.measure", "core.matching", "core.database", "core.rig"),
        *("core.recording", "core.mocap", "core.body", "core.maths"),
    },
    "core.evaluation": {
        *("core.pipeline", "core.measure", "core.matching", "core.database", "core.rig"),
        *("core.recording", "core.mocap", "core.body", "core.maths"),
    },
    "core.batch": {
        *("core.evaluation", "core.pipeline", "core.measure", "core.matching", "core.database", "core.rig"),
        *("core.recording", "core.mocap", "core.body", "core.maths"),
    },
    "nn": {"core"},
    "nn.train": {"nn", "core"},
    "bridge": {"core"},
    "properties": {"bridge", "nn", "core"},
    "operators": {"properties", "bridge", "nn.train", "nn", "core"},
    "panels": {"operators", "properties", "bridge", "nn", "core"},
    "cli": {"bridge", "nn.train", "nn", "core"},
}
"""What each part may import beside itself; a package of core stands for all of its parts."""
TORCH = {"nn.train.motion", "nn.train.paper", "nn.train.window", "nn.train.torch_networks"}
"""The modules that need torch; whoever uses them does so inside a function."""

IMPORT_ALL = """
import contextlib, importlib, io, pkgutil, sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in FOREIGN:
            raise ImportError(f"{name} must not be imported")

sys.meta_path.insert(0, Refuse())
import footwork.core, footwork.nn
for package in (footwork.core, footwork.nn):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if module.name.removeprefix("footwork.") not in TORCH:
            importlib.import_module(module.name)
# the help of a verb that needs Blender is made without it
from footwork.cli import main
with contextlib.redirect_stdout(io.StringIO()) as help:
    assert main(["bake", "--help"]) == 0
assert "--export" in help.getvalue()
print("all imported")
"""


def sources() -> list[Path]:
    """All modules of the packages that ARROWS names."""
    tops = {part.partition(".")[0] for part in ARROWS}
    return sorted(path for top in tops for path in (ROOT / top).rglob("*.py"))


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module_of(path) for path in sources()}


def imported(path: Path, *, at_import: bool = False) -> Iterator[str]:
    """Full names of what a module imports: of Footwork from its root on, of others their first name.

    Args:
        path: the module's file.
        at_import: only what is imported as soon as the module is, not inside functions.
    """
    package = list(path.relative_to(ROOT).parts[:-1])
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in tree.body if at_import else ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield (node.module or "").split(".")[0]
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1]
            base = ".".join([*above, *(node.module.split(".") if node.module else [])])
            for alias in node.names:
                inner = f"{base}.{alias.name}" if base else alias.name
                yield inner if inner in MODULES else base


def part_of(module: str) -> str:
    """The part of ARROWS that a module belongs to."""
    names = module.split(".")
    return ".".join(names[:2]) if names[0] == "core" or names[:2] == ["nn", "train"] else names[0]


def test_core_and_nn_import_without_blender_and_torch() -> None:
    script = f"FOREIGN, TORCH = {FOREIGN!r}, {TORCH!r}\n{IMPORT_ALL}"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "all imported"


def test_the_arrows_run_down() -> None:
    """No part stands in a circle of arrows, and database and rig do not know each other."""
    order = list(TopologicalSorter({part: ARROWS[part] - {"core"} for part in ARROWS}).static_order())
    assert order.index("core.maths") < order.index("core.body") < order.index("core.evaluation")
    assert "core.rig" not in ARROWS["core.database"] and "core.database" not in ARROWS["core.rig"]


@pytest.mark.parametrize("path", sources(), ids=module_of)
def test_modules_import_along_the_arrows(path: Path) -> None:
    module = module_of(path)
    part = part_of(module)
    for name in imported(path):
        # by its full name the extension is not even found in Blender
        assert name != "footwork", f"{module} imports Footwork by an absolute name"
        if name not in MODULES or name in ("core", part):
            continue
        other = part_of(name)
        if part in {f"core.{base}" for base in BASE}:
            assert other in {f"core.{base}" for base in BASE}, f"{module} imports {name}"
        elif part in ARROWS and other != part:
            common = part.startswith("core") and other in {f"core.{base}" for base in BASE}
            allowed = other in ARROWS[part] or (other.startswith("core.") and "core" in ARROWS[part])
            assert common or allowed, f"{module} imports {name}"


def test_every_part_is_drawn() -> None:
    """A new package, or a new module of core's own level, has to be put into ARROWS."""
    parts = {part_of(module) for module in MODULES} - {"core"}
    assert parts <= set(ARROWS) | {f"core.{base}" for base in BASE}


def test_every_package_is_installed() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    packages = {module for module in MODULES if (ROOT / Path(*module.split(".")) / "__init__.py").is_file()}
    assert set(listed) == {"footwork", *(f"footwork.{package}" for package in packages)}


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = {module_of(p): {n for n in imported(p) if n in MODULES} - {module_of(p)} for p in sources()}
    packages = {name for name in MODULES if (ROOT / Path(*name.split(".")) / "__init__.py").is_file()}
    order = TopologicalSorter(
        {module: others - packages for module, others in graph.items() if module not in packages}
    )
    assert len(list(order.static_order())) >= len(MODULES) - len(packages)


def test_torch_is_imported_by_training_alone() -> None:
    assert {module_of(path) for path in sources() if "torch" in imported(path)} == TORCH
    assert all(part_of(module) == "nn.train" for module in TORCH)


def test_blender_is_imported_only_above_core_and_nn() -> None:
    for path in sources():
        if path.relative_to(ROOT).parts[0] in ("core", "nn"):
            assert not {"bpy", "mathutils"} & set(imported(path)), path
        if path.relative_to(ROOT).parts[0] == "cli":
            assert not {"bpy", "mathutils"} & set(imported(path, at_import=True)), path
