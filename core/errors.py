"""The one error that stands for a person's input rather than for our bug."""

from __future__ import annotations

LONGEST = 400
"""Characters of a message at most."""
_HEAD = 240


class InputError(ValueError):
    """Bad input: the message is one line that says where (file, line or frame), what is wrong and what to do.

    The command line turns it into exit code 2, Blender into an error report. Names of files and what stands in them
    come into messages as they are: here they are made fit to be shown.
    """

    def __init__(self, message: str, *more: str) -> None:
        """One fault, or several: a line each."""
        self.lines = tuple(map(one_line, (message, *more)))
        super().__init__("\n".join(self.lines))


class FaultError(ValueError):
    """What is wrong with a file's content; becomes an InputError that names the file and says what to do."""


def one_line(text: str, most: int = LONGEST) -> str:
    """A text that any terminal and file can show as a line, whatever a file's name or content put into it.

    What is too long loses its middle: a message begins with the place and ends with what to do.
    """
    if not text.isprintable():
        text = " ".join(text.split())
        text = "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text)
    if len(text) <= most:
        return text
    return f"{text[:_HEAD]} ... {text[len(text) - (most - _HEAD - 5) :]}"
