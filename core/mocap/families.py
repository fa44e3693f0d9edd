"""Naming families: what each joint of a humanoid is called in one kind of file or rig (presets/bone_maps/*.json)."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..body.skeleton import ARM, LEG, REQUIRED_ROLES, SIDES, SPINE
from ..errors import InputError
from ..presets import Presets, check_keys, check_text, check_texts, load_presets, read_preset

KIND = "bone_maps"
"""Sub-folder of the presets."""
_NAMED_ROLES = ("hips", "neck", "head", *ARM, *LEG)
"""Roles a family names; the spine follows from the hierarchy unless the family lists it."""
_SIDED_ROLES = tuple(f"{part}.{side}" for part in (*ARM, *LEG) for side in SIDES)
"""Roles of one side, for names that have no word for sides."""


@dataclass(frozen=True, slots=True)
class NamingFamily:
    """One naming scheme. All names are reduced as by `reduce_name`."""

    name: str
    names: dict[str, tuple[str, ...]]
    """For each role the names it may have, in order of preference; no name has two roles."""
    spine: tuple[str, ...] = ()
    """Names of the spine's joints upwards, for rigs whose parents do not tell; else empty."""
    constrained: tuple[str, ...] = ()
    """Parts of limbs ("clavicle") that carry the next one by constraints, not as its parent."""


def families() -> Presets[NamingFamily]:
    """The families of the user's folder, then those that ship."""
    return load_presets(KIND, read_family)


def read_family(path: str | os.PathLike[str]) -> NamingFamily:
    """Read a bone map, a JSON file as the ones that ship.

    It has `name`, `sides` (left, right), and `joints`: for each role a name, or names in order of preference, with
    `{side}` in place of the side, or for a role of one side ("hand.L") its own. Optional: `spine` and `constrained`,
    see `NamingFamily`.

    Raises:
        InputError: unreadable, not JSON or not a bone map.
    """
    return read_preset(path, _parse, "bone map")


def reduce_name(name: str) -> str:
    """A name without what varies between exporters: case, separators, and all before a namespace's colon."""
    return re.sub(r"[\W_]+", "", re.split(r"[:|]", name)[-1]).lower()


def family_of(name: str, roles: Mapping[str, str]) -> dict[str, Any]:
    """A bone map, as its file has it, of bones as they are called: role -> name.

    Raises:
        InputError: a role that a body needs is missing, or two bones differ by nothing that counts.
    """
    chain = [roles[role] for role in SPINE if roles.get(role)]
    named = {role: bone for role, bone in roles.items() if bone and role not in SPINE}
    content: dict[str, Any] = {"name": name, "sides": ["Left", "Right"], "joints": named}
    if chain:
        content["spine"] = chain
    try:
        _parse(content)
    except ValueError as error:
        raise InputError(f"{name}: {error}; complete the role map") from None
    return content


def _parse(content: Any) -> NamingFamily:
    data = check_keys(content, ("name", "sides", "joints"), ("spine", "constrained"))
    left_right = check_texts(data["sides"], "'sides'", count=2)
    names: dict[str, tuple[str, ...]] = {}
    for role, given in check_keys(data["joints"], (), (*_NAMED_ROLES, *_SIDED_ROLES), "'joints'").items():
        templates = check_texts([given] if isinstance(given, str) else given, f"{role!r}")
        if role in _SIDED_ROLES:
            if role in names:
                raise ValueError(f"{role!r} is named twice")
            names[role] = tuple(map(reduce_name, templates))
        elif role in ARM or role in LEG:
            if any("{side}" not in template for template in templates):
                raise ValueError(f"{role!r} has a name without {{side}}")
            if any(f"{role}.{letter}" in names for letter in SIDES):
                raise ValueError(f"{role!r} is named twice")
            for letter, side in zip(SIDES, left_right, strict=True):
                names[f"{role}.{letter}"] = tuple(reduce_name(t.replace("{side}", side)) for t in templates)
        else:
            names[role] = tuple(map(reduce_name, templates))
    missing = [role for role in REQUIRED_ROLES if not names.get(role)]
    if missing:
        raise ValueError(
            f"'joints' has no {', '.join(dict.fromkeys(role.partition('.')[0] for role in missing))}"
        )
    spine = tuple(map(reduce_name, check_texts(data.get("spine", []), "'spine'")))
    _check_names({**names, "spine": spine})
    constrained = check_texts(data.get("constrained", []), "'constrained'")
    for part in constrained:
        if part not in (*ARM, *LEG):
            raise ValueError(f"'constrained' has {part!r}, which is none of {', '.join((*ARM, *LEG))}")
    return NamingFamily(check_text(data["name"], "'name'"), names, spine, constrained)


def _check_names(names: dict[str, tuple[str, ...]]) -> None:
    """Raise ValueError for a name that is nothing but separators, or that two joints have."""
    owners: dict[str, str] = {}
    for role, some in names.items():
        for name in some:
            if not name:
                raise ValueError(f"{role!r} has a name without letters and digits")
            if name in owners and (owners[name] != role or role == "spine"):
                raise ValueError(f"{owners[name]!r} and {role!r} have the same name {name!r}")
            owners[name] = role
