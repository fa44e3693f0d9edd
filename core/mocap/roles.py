"""Humanoid joint roles, found by matching whole naming families with a check of the hierarchy.

"LeftShoulder" is an upper arm for Xsens and a collar bone for Mixamo, so no name is ever taken alone: a
family fits only where all joints that a body needs bear its names and hang on each other as limbs do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.skeleton import ARM, LEG, REQUIRED_ROLES, SIDES, SPINE
from ..errors import InputError
from ..presets import user_folder
from .families import KIND, NamingFamily, families, reduce_name
from .recognise.recognise import NAME, roles_by_structure

Array = NDArray[np.floating[Any]]

_SPINE_ROLES = ((), ("chest",), ("spine1", "chest"), ("spine1", "spine3", "chest"), SPINE)
"""Roles of a spine of so many joints."""


@dataclass(frozen=True, slots=True)
class RoleMatch:
    """Which joint is what."""

    family: str
    """Name of the naming family that fits."""
    roles: tuple[str, ...]
    """`(J,)` role of each joint, "" for none."""
    doubts: tuple[str, ...]
    """One line for each thing a person should look at."""


def match_roles(
    names: Sequence[str],
    parents: NDArray[np.intp],
    among: Sequence[NamingFamily] | None = None,
    needed: Sequence[str] = REQUIRED_ROLES,
    apart: bool = False,
    poses: Callable[[], Array] | None = None,
) -> RoleMatch:
    """Find the role of every joint.

    Prefixes such as "mixamorig:" or "Bip001 ", endings that all names share, such as ".001", upper and lower case and
    separators do not matter.

    Args:
        names: joint or bone names `(J,)`.
        parents: `(J,)` index of each one's parent, -1 for none; parents may follow their children.
        among: naming families to try, in order of preference; None for all that are known.
        needed: roles that must be found.
        poses: gives positions `(F, J, 3)` of the joints in some poses, in any axes and unit; asked for where no family
            fits, to recognise joints by words in their names and by structure. None for known families alone.
        apart: whether a part of a leg may hang on the root, the hips or a part further up, as in some rigs.

    Raises:
        InputError: no family has every joint that a body needs; says which one came nearest.
    """
    reduced = [reduce_name(name) for name in names]
    ancestors = [hierarchy.above(parents, joint) for joint in range(len(parents))]
    best: dict[str, int] = {}
    fitting: NamingFamily | None = None
    nearest: tuple[int, str, list[str]] = (0, "", [])
    for family in families().entries if among is None else among:
        for affixes in _affixes(family, reduced):
            found = _find(family, affixes, reduced, ancestors, apart)
            missing = [role for role in needed if role not in found]
            if not missing and len(found) > len(best):
                best, fitting = found, family
            if missing and len(found) > nearest[0]:
                nearest = (len(found), family.name, missing)
    if fitting is None:
        return _by_structure(names, parents, needed, poses, nearest)
    doubts = [
        f"several joints are called {names[joint]}; the first is taken as {role}"
        for role, joint in best.items()
        if list(names).count(names[joint]) > 1
    ]
    roles = [""] * len(names)
    for role, joint in (_spine(fitting, best, reduced, ancestors) | best).items():
        roles[joint] = role
    return RoleMatch(fitting.name, tuple(roles), tuple(doubts))


def _by_structure(
    names: Sequence[str],
    parents: NDArray[np.intp],
    needed: Sequence[str],
    poses: Callable[[], Array] | None,
    nearest: tuple[int, str, list[str]],
) -> RoleMatch:
    """The joints as words and structure tell; InputError with the nearest family where they do not."""
    if poses is None or len(names) < len(needed):
        raise InputError(_no_match(nearest))
    try:
        found, doubts = roles_by_structure(names, parents, poses())
    except InputError as error:
        raise InputError(f"{_no_match(nearest)} ({error})") from None
    missing = [role for role in needed if role not in found]
    if missing:
        raise InputError(_no_match((len(found), NAME, missing)))
    hips = found["hips"]
    over = hierarchy.above(parents, hips)
    if any(found[role] in over for role in found):
        raise InputError(
            f"{names[over[0]]} is above the hips {names[hips]}: a tree from the head down is not read; "
            "export it with the hips as root"
        )
    arms = [hierarchy.above(parents, found[f"upper_arm.{side}"]) for side in SIDES]
    end = found.get("neck", found["head"])
    between = hierarchy.above(parents, end)
    between = between[: between.index(hips)][::-1] if hips in between else []
    chain = [joint for joint in between if all(joint in arm for arm in arms)]
    roles = [""] * len(names)
    for role, joint in (_spread(chain) | found).items():
        roles[joint] = role
    return RoleMatch(NAME, tuple(roles), doubts)


def _affixes(family: NamingFamily, reduced: Sequence[str]) -> list[tuple[str, str]]:
    """What could stand before and after every name: whatever does of a name of the hips, the shortest first."""
    found = {
        (name[:at], name[at + len(hips) :])
        for name in reduced
        for hips in family.names["hips"]
        for at in range(len(name) - len(hips) + 1)
        if name.startswith(hips, at)
    }
    return sorted(found, key=lambda affixes: (len(affixes[0]) + len(affixes[1]), affixes))


def _find(
    family: NamingFamily,
    affixes: tuple[str, str],
    reduced: Sequence[str],
    ancestors: Sequence[Sequence[int]],
    apart: bool,
) -> dict[str, int]:
    """The joints that bear this family's names between the affixes and hang where they should."""
    before, after = affixes
    first: dict[str, int] = {}
    for joint in reversed(range(len(reduced))):
        first[reduced[joint]] = joint
    found: dict[str, int] = {}
    for role, names in family.names.items():
        full = [before + name + after for name in names]
        joint = next((first[name] for name in full if name in first), None)
        if joint is not None:
            found[role] = joint
    return {
        role: joint for role, joint in found.items() if _hangs_well(family, role, found, ancestors, apart)
    }


def _hangs_well(
    family: NamingFamily, role: str, found: dict[str, int], ancestors: Sequence[Sequence[int]], apart: bool
) -> bool:
    """Whether a joint lies below the hips and below its own limb's joints, and below no other limb."""
    above = {other for other, index in found.items() if index in ancestors[found[role]]}
    if role == "hips":
        return not above
    part, _, side = role.partition(".")
    if "hips" in found and "hips" not in above and not (apart and part in LEG):
        return False
    limb: tuple[str, ...] = ARM if part in ARM else LEG if part in LEG else ("neck", "head")
    before = [f"{name}.{side}" if side else name for name in limb[: limb.index(part)]]
    needed = {other for other in before if other.partition(".")[0] not in family.constrained}
    # some rigs hang the collar bones on the neck
    allowed = {"hips", "neck", *before} if limb is ARM else {"hips", *before}
    if apart and part in LEG:
        return above <= allowed
    return needed & found.keys() <= above <= allowed


def _spine(
    family: NamingFamily, found: dict[str, int], reduced: Sequence[str], ancestors: Sequence[Sequence[int]]
) -> dict[str, int]:
    """Roles of the joints between the hips and the neck: the last is the chest, the first spine1."""
    chain = [reduced.index(name) for name in family.spine if name in reduced]
    if not family.spine:
        end = found.get("neck", found["head"])
        between = ancestors[end][: ancestors[end].index(found["hips"])][::-1]
        # what lies above the arms' root is neck, named so or not
        arms = [ancestors[found[f"upper_arm.{side}"]] for side in SIDES]
        chain = [joint for joint in between if all(joint in arm for arm in arms)]
    return _spread(chain)


def _spread(chain: Sequence[int]) -> dict[str, int]:
    """Roles of the joints of a spine upwards."""
    count = min(len(chain), len(SPINE))
    steps = np.round(np.linspace(0, len(chain) - 1, count)).astype(int).tolist()
    return {role: chain[step] for role, step in zip(_SPINE_ROLES[count], steps, strict=True)}


def _no_match(nearest: tuple[int, str, list[str]]) -> str:
    count, family, missing = nearest
    advice = f"a bone map in {user_folder(KIND)}{families().note}"
    if count == 0:
        return f"no known joint names; rename the joints or add {advice}"
    return f"joint names fit no bone map; {family} is nearest but lacks {', '.join(missing)}; add {advice}"
