"""The arrows between packages go one way, and the method runs without Blender and torch."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOREIGN = {"bpy", "mathutils", "gpu", "bl_ui", "torch", "scipy", "matplotlib", "optuna", "pymotion"}
ABOVE = {
    "core": {"nn", "bridge", "operators", "panels", "cli"},
    "nn": {"bridge", "operators", "panels", "cli"},
    "bridge": {"operators", "panels", "cli"},
    "operators": {"panels"},
}

IMPORT_ALL = """
import importlib, pkgutil, sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in FOREIGN:
            raise ImportError(f"{name} must not be imported")

sys.meta_path.insert(0, Refuse())
import footwork.core, footwork.nn
for package in (footwork.core, footwork.nn):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not module.name.startswith("footwork.nn.train_"):  # what nn.train fetches when training starts
            importlib.import_module(module.name)
print("all imported")
"""


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def imports(path: Path) -> set[str]:
    """Top-level names of absolute imports, and `.package` for relative imports that reach Footwork's root."""
    depth = len(path.relative_to(ROOT).parts) - 1
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add((node.module or "").split(".")[0])
        elif isinstance(node, ast.ImportFrom) and node.level == depth + 1:
            names = [node.module.split(".")[0]] if node.module else [alias.name for alias in node.names]
            found |= {f".{name}" for name in names}
    return found


def test_core_and_nn_import_without_blender_and_torch() -> None:
    script = f"FOREIGN = {FOREIGN!r}\n{IMPORT_ALL}"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "all imported"


@pytest.mark.parametrize("package", sorted(ABOVE))
def test_no_package_imports_one_above_it(package: str) -> None:
    for path in modules(package):
        upward = {name for name in ABOVE[package] if f".{name}" in imports(path)}
        assert not upward, f"{path.relative_to(ROOT)} imports {upward}"


def test_torch_is_imported_by_training_alone() -> None:
    users = [path for package in (*ABOVE, "panels") for path in modules(package) if "torch" in imports(path)]
    assert all(path.parent.name == "nn" and path.name.startswith("train") for path in users)


def test_blender_is_imported_only_above_core_and_nn() -> None:
    users = [path for package in ("core", "nn") for path in modules(package)]
    for path in [*users, *modules("cli")]:
        assert not {"bpy", "mathutils"} & top_level_imports(path), path


def top_level_imports(path: Path) -> set[str]:
    """Names imported when the module is imported, not inside functions."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names: set[str] = set()
    for node in tree.body:
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add((node.module or "").split(".")[0])
    return names
