"""What makes a verb of the command line."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..core.transaction import Transaction

Report = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Verb:
    """One job of the command line."""

    name: str
    help: str
    """What it does, in lower case and without a full stop, for the list of verbs and its own help."""
    add_arguments: Callable[[argparse.ArgumentParser], None]
    """Adds its arguments; `--json` comes by itself."""
    run: Callable[[argparse.Namespace, Transaction], Report]
    """Does the job and puts all its outputs into the transaction; a report with something under "failed" ends with exit
    code 3, with something under "unfinished" with 4."""
    prepare: Callable[[argparse.Namespace], None] = lambda options: None
    """Completes the options from files that they name, before anything is looked at; InputError where that fails."""
    maps_bones: bool = False
    """Whether it reads takes or rigs, whose names may need a bone map."""
    when_cancelled: Callable[[argparse.Namespace], str] = lambda options: ""
    """What to say after "cancelled"."""
