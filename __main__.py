"""`python -m footwork VERB`: the command line where bpy, if it is needed at all, is a Python module."""

import contextlib
import os
import sys


def run() -> None:
    """Run the command line and leave."""
    try:
        from .cli import main

        code = main()
    except KeyboardInterrupt:  # while Python was still loading
        code = 2
    for stream in (sys.stdout, sys.stderr):
        # nobody may be there to hear it any more
        with contextlib.suppress(OSError):
            stream.flush()
    # some bpy modules crash or hang while Python tears them down; everything is written by now
    os._exit(code)


# processes that Python's own pools start read this file, too
if __name__ == "__main__":
    run()
