"""Steps of the method that can be exchanged: each is one entry here, and a function that the entry names.

An entry adds the method's name to the choices of its setting, and with that to the panel, the command line and the
reports. New ones go to the end, since a scene keeps its choice by its place. The function is loaded when it is first
used, so that this module may stand below all others.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Method:
    """One way to do a step."""

    name: str
    """Value of the setting, in lower case."""
    help: str
    """One sentence without a final period, the tooltip."""
    function: str | Callable[..., Any]
    """The function, or where it is found: "package.module:name", seen from `core`."""


class Methods(Mapping[str, str]):
    """The ways to do one step by name; as a mapping, each name with its help."""

    def __init__(self, *methods: Method) -> None:
        self._methods = {method.name: method for method in methods}

    def add(self, method: Method) -> None:
        """Add one, or replace the one of the same name."""
        self._methods[method.name] = method

    def remove(self, name: str) -> None:
        """Take one away."""
        del self._methods[name]

    def function(self, name: str) -> Callable[..., Any]:
        """The function of a method.

        Raises:
            KeyError: there is none of this name.
        """
        function = self._methods[name].function
        if isinstance(function, str):
            module, _, attribute = function.partition(":")
            function = getattr(importlib.import_module(f".{module}", __package__), attribute)
        return function

    def __getitem__(self, name: str) -> str:
        return self._methods[name].help

    def __iter__(self) -> Iterator[str]:
        return iter(self._methods)

    def __len__(self) -> int:
        return len(self._methods)


SEARCHES = Methods(
    Method(
        "greedy", "The best frame at each search, as in the paper", "matching.greedy_search:find_greedily"
    ),
    Method(
        "path",
        "The best path through the databases over the whole recording; slower",
        "matching.path_search:find_path",
    ),
)
"""How frames are chosen: `(trajectory, wanted, databases, settings) -> Job[Schedule]` (see `matching.schedule`)."""

FOOT_PLANS = Methods(
    Method("planted", "Feet that touch the ground stay where they are", "rig.feet:plant_feet"),
    Method("matched", "Feet go where the matched motion has them", "rig.feet:follow_feet"),
)
"""Where feet go: `(motion, contacts, settings, body) -> FootPlan` (see `rig.feet`)."""

TRAVELS = {
    "hips": "The hips carry the way over the ground",
    "root": "The bone above all others carries the way and the direction, the hips what is left",
    "in-place": "The body stays where it starts; it turns and goes up and down",
}
"""What can become of the way over the ground."""
ENGINES = {
    "unreal": "FBX with the deforming bones, smoothing by faces; the way on a root bone where there is one",
    "unity": "FBX with the deforming bones, all scales applied; the way on a root bone where there is one",
    "godot": "glTF or FBX with the deforming bones; the way on a root bone where there is one",
}
"""Game engines that an export can be made for."""
