"""Humanoid joint roles, found by matching whole naming presets with a check of the hierarchy.

"LeftShoulder" is an upper arm for Xsens and a collar bone for Mixamo, so no name is ever taken alone: a
preset fits only where all joints that a body needs bear its names and hang on each other as limbs do.
"""

from __future__ import annotations

import functools
import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.skeleton import ARM, LEG, REQUIRED_ROLES, SIDES, SPINE
from ..errors import InputError

PRESETS = Path(__file__).parents[2] / "presets" / "bone_maps"
"""The presets that ship."""
_NAMED_ROLES = ("hips", "neck", "head", *ARM, *LEG)
"""Roles a preset names; the spine follows from the hierarchy unless the preset lists it."""
_SPINE_ROLES = ((), ("chest",), ("spine1", "chest"), ("spine1", "spine3", "chest"), SPINE)
"""Roles of a spine of so many joints."""


@dataclass(frozen=True, slots=True)
class Preset:
    """One naming scheme. All names are reduced as by `_reduce`."""

    name: str
    names: dict[str, tuple[str, ...]]
    """For each role the names it may have."""
    spine: tuple[str, ...] = ()
    """Names of the spine's joints upwards, for rigs whose parents do not tell; else empty."""
    constrained: tuple[str, ...] = ()
    """Parts of limbs ("clavicle") that carry the next one by constraints, not as its parent."""


@dataclass(frozen=True, slots=True)
class RoleMatch:
    """Which joint is what."""

    preset: str
    """Name of the scheme that fits."""
    roles: tuple[str, ...]
    """`(J,)` role of each joint, "" for none."""
    doubts: tuple[str, ...]
    """One line for each thing a person should look at."""


def match_roles(
    names: Sequence[str], parents: NDArray[np.intp], presets: Sequence[Preset] | None = None
) -> RoleMatch:
    """Find the role of every joint.

    Prefixes such as "mixamorig:" or "Bip001 ", upper and lower case and separators do not matter.

    Args:
        names: joint or bone names `(J,)`.
        parents: `(J,)` index of each one's parent, -1 for none; parents may follow their children.
        presets: naming schemes to try, in order of preference; None for those that ship.

    Raises:
        InputError: no scheme has every joint that a body needs; says which one came nearest.
    """
    reduced = [_reduce(name) for name in names]
    ancestors = [hierarchy.above(parents, joint) for joint in range(len(parents))]
    best: dict[str, int] = {}
    fitting: Preset | None = None
    nearest: tuple[int, str, list[str]] = (0, "", [])
    for preset in shipped_presets() if presets is None else presets:
        for prefix in _prefixes(preset, reduced):
            found = _find(preset, prefix, reduced, ancestors)
            missing = [role for role in REQUIRED_ROLES if role not in found]
            if not missing and len(found) > len(best):
                best, fitting = found, preset
            if missing and len(found) > nearest[0]:
                nearest = (len(found), preset.name, missing)
    if fitting is None:
        raise InputError(_no_match(nearest))
    doubts = [
        f"several joints are called {names[joint]}; the first is taken as {role}"
        for role, joint in best.items()
        if list(names).count(names[joint]) > 1
    ]
    roles = [""] * len(names)
    for role, joint in (best | _spine(fitting, best, reduced, ancestors)).items():
        roles[joint] = role
    return RoleMatch(fitting.name, tuple(roles), tuple(doubts))


@functools.cache
def shipped_presets() -> tuple[Preset, ...]:
    """The presets that ship, in order of their file names."""
    return tuple(read_preset(path) for path in sorted(PRESETS.glob("*.json")))


def read_preset(path: str | os.PathLike[str]) -> Preset:
    """Read a bone map, a JSON file as the ones that ship.

    It has `name`, `sides` (left, right), and `joints`: for each role a name, or names in order of preference, with
    `{side}` in place of the side. Optional: `spine` and `constrained`, see `Preset`.

    Raises:
        InputError: unreadable, not JSON or not a bone map.
    """
    try:
        data: Any = json.loads(Path(path).read_text(encoding="utf-8"))
        preset = _preset(data)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: is not a bone map ({error}); compare it with those that ship") from error
    missing = [role for role in REQUIRED_ROLES if role not in preset.names]
    if missing:
        raise InputError(f"{path}: the bone map has no {', '.join(missing)}; add them")
    return preset


def _preset(data: Any) -> Preset:
    sides = cast("list[str]", data["sides"])
    names: dict[str, tuple[str, ...]] = {}
    for role, given in data["joints"].items():
        if role not in _NAMED_ROLES:
            raise ValueError(f"{role!r} is none of {', '.join(_NAMED_ROLES)}")
        templates = [given] if isinstance(given, str) else cast("list[str]", given)
        if role in ARM or role in LEG:
            for letter, side in zip(SIDES, sides, strict=True):
                names[f"{role}.{letter}"] = tuple(_reduce(t.replace("{side}", side)) for t in templates)
        else:
            names[role] = tuple(map(_reduce, templates))
    spine = tuple(map(_reduce, cast("list[str]", data.get("spine", []))))
    return Preset(str(data["name"]), names, spine, tuple(data.get("constrained", [])))


def _reduce(name: str) -> str:
    """A name without what varies between exporters: case, separators, and all before a namespace's colon."""
    return re.sub(r"[\W_]+", "", re.split(r"[:|]", name)[-1]).lower()


def _prefixes(preset: Preset, reduced: Sequence[str]) -> list[str]:
    """What could stand before every name: whatever stands before a name of the hips, none first."""
    ends = preset.names["hips"]
    found = {name[: len(name) - len(end)] for name in reduced for end in ends if name.endswith(end)}
    return sorted(found, key=lambda prefix: (len(prefix), prefix))


def _find(
    preset: Preset, prefix: str, reduced: Sequence[str], ancestors: Sequence[Sequence[int]]
) -> dict[str, int]:
    """The joints that bear this preset's names and hang where they should."""
    first: dict[str, int] = {}
    for joint in reversed(range(len(reduced))):
        first[reduced[joint]] = joint
    found: dict[str, int] = {}
    for role, names in preset.names.items():
        joint = next((first[prefix + name] for name in names if prefix + name in first), None)
        if joint is not None:
            found[role] = joint
    return {role: joint for role, joint in found.items() if _hangs_well(preset, role, found, ancestors)}


def _hangs_well(preset: Preset, role: str, found: dict[str, int], ancestors: Sequence[Sequence[int]]) -> bool:
    """Whether a joint lies below the hips and below its own limb's joints, and below no other limb."""
    above = {other for other, index in found.items() if index in ancestors[found[role]]}
    if role == "hips":
        return not above
    if "hips" in found and "hips" not in above:
        return False
    part, _, side = role.partition(".")
    limb: tuple[str, ...] = ARM if part in ARM else LEG if part in LEG else ("neck", "head")
    before = [f"{name}.{side}" if side else name for name in limb[: limb.index(part)]]
    needed = {other for other in before if other.partition(".")[0] not in preset.constrained}
    # some rigs hang the collar bones on the neck
    allowed = {"hips", "neck", *before} if limb is ARM else {"hips", *before}
    return needed & found.keys() <= above <= allowed


def _spine(
    preset: Preset, found: dict[str, int], reduced: Sequence[str], ancestors: Sequence[Sequence[int]]
) -> dict[str, int]:
    """Roles of the joints between the hips and the neck: the last is the chest, the first spine1."""
    chain = [reduced.index(name) for name in preset.spine if name in reduced]
    if not preset.spine:
        end = found.get("neck", found["head"])
        between = ancestors[end][: ancestors[end].index(found["hips"])][::-1]
        # what lies above the arms' root is neck, named so or not
        arms = [ancestors[found[f"upper_arm.{side}"]] for side in SIDES]
        chain = [joint for joint in between if all(joint in arm for arm in arms)]
    count = min(len(chain), len(SPINE))
    steps = np.round(np.linspace(0, len(chain) - 1, count)).astype(int).tolist()
    return {role: chain[step] for role, step in zip(_SPINE_ROLES[count], steps, strict=True)}


def _no_match(nearest: tuple[int, str, list[str]]) -> str:
    count, preset, missing = nearest
    if count == 0:
        return "no known joint names; rename the joints or add a bone map"
    return f"joint names fit no bone map; {preset} is nearest but lacks {', '.join(missing)}; add a bone map"
