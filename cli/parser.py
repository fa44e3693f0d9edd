"""The table of verbs and the parser made from it."""

from __future__ import annotations

import argparse
from typing import Any

from .bake import BAKE
from .batch import BATCH
from .compare import COMPARE_REPORTS
from .database import BUILD_DATABASE, DATABASE_INFO
from .evaluate import EVALUATE
from .mapping import MAP
from .options import OutputPath, add_bone_map
from .predictor import EVALUATE_PREDICTOR, TRAIN_PREDICTOR
from .starter import STARTER
from .takes import INSPECT, SIMULATE_RECORDING
from .verb import Verb

VERBS = (
    INSPECT,
    MAP,
    BUILD_DATABASE,
    DATABASE_INFO,
    STARTER,
    TRAIN_PREDICTOR,
    EVALUATE_PREDICTOR,
    SIMULATE_RECORDING,
    BAKE,
    BATCH,
    EVALUATE,
    COMPARE_REPORTS,
)
"""Every verb, in the order of the help."""


class VerbParser(argparse.ArgumentParser):
    """The parser of one verb, which adds its arguments once it is to parse: they may load half of Footwork."""

    def __init__(self, *, verb: Verb, **how: Any) -> None:
        super().__init__(**how)
        self._verb: Verb | None = verb

    def parse_known_args(self, *args: Any, **how: Any) -> Any:
        """As argparse does, after the verb's arguments are added."""
        self.add_arguments()
        return super().parse_known_args(*args, **how)

    def add_arguments(self) -> None:
        """Add the verb's arguments, once."""
        if self._verb is None:
            return
        self.set_defaults(chosen=self._verb)
        self.add_argument(
            "--json",
            type=OutputPath,
            metavar="FILE",
            help="write a machine-readable report, - for standard output",
        )
        if self._verb.maps_bones:
            add_bone_map(self)
        self._verb.add_arguments(self)
        self._verb = None


def make_parser() -> argparse.ArgumentParser:
    """The parser of all verbs."""
    parser = argparse.ArgumentParser(
        prog="footwork",
        description="Full-body animation from a VR headset and two hand controllers.",
        epilog="footwork VERB --help tells what a verb can do. Exit codes: 0 done, 2 bad usage, bad input or cancelled "
        "(nothing written), 3 a limit of --fail-if is passed, 4 some recordings of a batch failed, 1 a bug of ours.",
    )
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True, parser_class=VerbParser)
    for verb in VERBS:
        description = f"{verb.help[0].upper()}{verb.help[1:]}."
        verbs.add_parser(verb.name, verb=verb, help=verb.help, description=description)
    return parser
