"""What counts as a mutant, where it is said to be, and how sure a score is."""

from __future__ import annotations

import importlib.util
import sys
from collections import Counter
from pathlib import Path

import pytest

SPEC = importlib.util.spec_from_file_location("mutants", Path(__file__).parents[1] / "tools" / "mutants.py")
assert SPEC is not None and SPEC.loader is not None
mutants = sys.modules["mutants"] = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(mutants)


@pytest.mark.parametrize(
    ("before", "after", "rule"),
    [
        ('notes.append("too few frames")', 'notes.append("XXtoo few framesXX")', "text"),
        ('notes.append("too few frames")', 'notes.append("TOO FEW FRAMES")', "text"),
        ('notes.append("too few frames")', "notes.append(None)", ""),
        ('role = "thigh"', 'role = "XXthighXX"', ""),
        ("zip(a, b, strict=True)", "zip(a, b, strict=False)", "strict"),
        ("zip(a, b, strict=True)", "zip(a, b, )", "strict"),
        ("zip(a, b, strict=True)", "zip(b, strict=True)", ""),
        ("zip(a, b, strict=True)", "zip(a, None, strict=True)", ""),
        ('cast("list[str]", a)', "cast(None, a)", "cast"),
        ('cast("list[str]", a)', 'cast("XXlist[str]XX", a)', "cast"),
        ('cast("list[str]", a)', 'cast("list[str]", None)', ""),
        ('cast("list[str]", a)', "cast(a)", ""),
        ('np.empty(3, order="F")', "np.empty(3, order=None)", "memory"),
        ('np.empty(3, order="F")', 'np.empty(None, order="F")', ""),
        ("w -= times(a, b, out=part)", "w -= times(a, b, out=None)", "memory"),
        ("w -= times(a, b, out=part)", "w += times(a, b, out=part)", ""),
        ("w -= times(a, b, out=part)", "w -= times(a, None, out=part)", ""),
        ("times(a, b, out=part)", "times(a, b, out=None)", ""),
        ('np.einsum("ij,j->i", a, b)', 'np.einsum("IJ,J->I", a, b)', "capitals"),
        ('np.einsum("ij,j->i", a, b)', 'np.einsum("XXij,j->iXX", a, b)', ""),
        ('raw.decode("utf-8")', 'raw.decode("UTF-8")', "capitals"),
        ("a < b", "a <= b", ""),
    ],
)
def test_only_changes_that_are_none_of_behaviour_are_excluded(before: str, after: str, rule: str) -> None:
    assert mutants.why_excluded(f"def f():\n    {before}\n", f"def f():\n    {after}\n") == rule


SOURCE = '''"""Shapes."""


def area(a):
    # a square
    return a * a


class Box:
    def volume(self):
        side = self.side
        return side**3
'''
MUTATED = '''"""Shapes."""


def area(a):
    # a square
    return a * a


def x_area__mutmut_orig(a):
    # a square
    return a * a


def x_area__mutmut_1(a):
    # a square
    return a / a


class Box:
    def volume(self):
        return self.xǁBoxǁvolume__mutmut_orig()

    def xǁBoxǁvolume__mutmut_orig(self):
        side = self.side
        return side**3

    def xǁBoxǁvolume__mutmut_1(self):
        side = None
        return side**3

    def xǁBoxǁvolume__mutmut_2(self):
        side = self.side
        return side**4
'''


def test_mutants_are_named_and_placed_in_the_source() -> None:
    found = mutants.mutants_of("core/shapes.py", SOURCE, MUTATED)
    assert [(m.name, m.line, m.after[0].strip()) for m in found] == [
        ("footwork.core.shapes.x_area__mutmut_1", 6, "return a / a"),
        ("footwork.core.shapes.xǁBoxǁvolume__mutmut_1", 11, "side = None"),
        ("footwork.core.shapes.xǁBoxǁvolume__mutmut_2", 12, "return side**4"),
    ]


def test_what_survived_is_read_back_from_the_list(tmp_path: Path) -> None:
    found = mutants.mutants_of("core/shapes.py", SOURCE, MUTATED)
    file = tmp_path / "shapes.txt"
    file.write_text("\n\n".join(map(str, found[:2])), encoding="utf-8")
    assert mutants.survivors_of(file) == {m.name for m in found[:2]}
    assert mutants.survivors_of(tmp_path / "none.txt") == set()


def test_a_timeout_counts_as_noticed_and_a_full_run_has_no_error() -> None:
    names = [mutants.Mutant(f"m{i}", "core/a.py", i, (), ()) for i in range(4)]
    fates = dict(zip(names, ("killed", "timeout", "killed", "survived"), strict=True))
    assert mutants.Score("rig", 4, Counter(), fates).share == 0.75
    assert mutants.Score("rig", 4, Counter(), fates).error == 0.0
    # sqrt(0.75 * 0.25 / 4 * (40 - 4) / (40 - 1)), drawn from 40 without putting back
    assert mutants.Score("rig", 40, Counter(), fates).error == pytest.approx(0.208013, abs=1e-6)
