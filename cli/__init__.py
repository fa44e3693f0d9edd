"""The command line: `blender --command footwork VERB`, and `python -m footwork VERB` where bpy is a Python module.

Each verb is a `verb.Verb` in a module of its own or with its like, and an entry in `parser.VERBS`. Nothing heavier than
argparse is imported before a verb is chosen.
"""

from .entry import main

__all__ = ["main"]
