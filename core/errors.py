"""The one error that stands for a person's input rather than for our bug."""

from __future__ import annotations


class InputError(ValueError):
    """Bad input: the message is one line that says where (file, line or frame), what is wrong and what to do.

    The command line turns it into exit code 2, Blender into an error report.
    """
