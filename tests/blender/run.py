"""Run the tests of this folder on the extension as users get it.

The zip is built with Blender's own packager, installed into an empty user folder and enabled; tests import it as
`footwork`. Use a Python with bpy and pytest: `python tests/blender/run.py [pytest arguments]`.
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import os
import sys
import tempfile
import traceback
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
INSTALLED = "bl_ext.user_default.footwork"


class _Installed(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Gives the installed extension's modules under their plain name, the very same module objects."""

    def find_spec(self, name, path=None, target=None):
        if name != "footwork" and not name.startswith("footwork."):
            return None
        return importlib.machinery.ModuleSpec(name, self)

    def create_module(self, spec) -> ModuleType:
        module = importlib.import_module(INSTALLED + spec.name.removeprefix("footwork"))
        self._own_spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self._own_spec


def main(arguments: list[str], folder: Path) -> int:
    """Install into `folder`, enable, test, disable."""
    os.environ["BLENDER_USER_RESOURCES"] = str(folder)
    os.environ["FOOTWORK_BLENDER_TESTS"] = "1"
    # a run on one Blender must not meet compiled files of another's Python
    sys.dont_write_bytecode = True
    import bpy
    import pytest

    sys.path.insert(0, str(ROOT / "tools"))
    from build_extension import build

    # importable only once bpy is imported
    addon_utils = importlib.import_module("addon_utils")
    print(f"Blender {bpy.app.version_string}, Python {sys.version.split()[0]}", flush=True)
    zip_path = build(folder)
    os.environ["FOOTWORK_ZIP"] = str(zip_path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(
        filepath=str(zip_path), repo="user_default", enable_on_install=True
    )
    if addon_utils.check(INSTALLED) != (True, True):
        print("the extension could not be enabled")
        return 1
    sys.meta_path.insert(0, _Installed())
    code = int(
        pytest.main([str(HERE), "-c", str(ROOT / "pyproject.toml"), "-p", "no:cacheprovider", *arguments])
    )
    addon_utils.disable(INSTALLED)
    return code


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="footwork-", ignore_cleanup_errors=True) as user:
        try:
            result = main(sys.argv[1:], Path(user))
        except BaseException:
            traceback.print_exc()
            result = 1
    sys.stdout.flush()
    sys.stderr.flush()
    # some bpy modules crash or hang while Python tears them down
    os._exit(result)
