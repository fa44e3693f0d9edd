"""Seeded fuzzing of every reader: whatever a file holds, it is read, or refused with one line.

Half of the inputs are sound files with changed values, shapes and counts; the others have changed bytes. What is read
is carried on: takes are resampled and become databases, databases are described and baked with, predictors predict,
reports are compared. Only InputError may come of it, within a second and 300 MB. What fails is kept in out/fuzz.
"""

from __future__ import annotations

import argparse
import hashlib
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import numpy as np
from footwork.core.errors import InputError
from fuzz_changes import change_bytes
from fuzz_readers import Reader, readers

ROOT = Path(__file__).parents[1]
SECONDS, GROWTH, ADDRESSES = 1.0, 300 << 20, 3 << 30


def fault_of(reader: Reader, path: Path, rng: random.Random) -> tuple[str, bool]:
    """What is wrong with how a file is taken, "" for nothing, and whether it was read."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start, read = time.process_time(), False
    signal.setitimer(signal.ITIMER_REAL, 60.0)
    try:
        reader.carry(path, rng)
        read = True
    except InputError as error:
        text = str(error)
        if not text.isprintable() or len(text) > 300:
            return f"message {text!r}", False
    except Exception as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__} at {Path(at.filename).name}:{at.lineno}: {error}"[:200], False
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    seconds = time.process_time() - start
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    if seconds > SECONDS * (1 if not read else 5):
        return f"{seconds:.1f} s", read
    return (f"{grown >> 20} MB" if grown > GROWTH else ""), read


def give_up(*_: object) -> None:
    """A minute is more than slow."""
    raise TimeoutError("takes more than a minute")


def fuzz(count: int, seed: int, only: str, output: Path) -> int:
    """Try `count` inputs; the number that failed."""
    failed: Counter[str] = Counter()
    tally: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        kinds = [reader for reader in readers(folder) if only in ("", reader.name)]
        for reader in kinds:
            (folder / "sound").with_suffix(reader.suffix).write_bytes(reader.sound)
            reader.carry((folder / "sound").with_suffix(reader.suffix), random.Random(0))
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, resource.getrlimit(resource.RLIMIT_AS)[1]))
        signal.signal(signal.SIGALRM, give_up)
        start = time.perf_counter()
        for number in range(count):
            rng = random.Random(f"{seed} {number}")
            reader = kinds[number % len(kinds)]
            structured = rng.random() < 0.5
            content = (reader.change if structured else change_bytes)(rng, reader.sound)
            path = (folder / "input").with_suffix(reader.suffix)
            path.write_bytes(content)
            fault, read = fault_of(reader, path, rng)
            tally["structured" if structured else "bytes"] += 1
            tally["read"] += read
            if fault:
                if failed[f"{reader.name}: {fault}"] == 0:
                    output.mkdir(parents=True, exist_ok=True)
                    digest = hashlib.sha256(content).hexdigest()[:8]
                    kept = output / f"{reader.name.replace(' ', '_')}_{number}_{digest}{reader.suffix}"
                    kept.write_bytes(content)
                    print(f"{kept}: {fault}", flush=True)
                failed[f"{reader.name}: {fault}"] += 1
        seconds = time.perf_counter() - start
    print(
        f"{count} inputs in {seconds:.0f} s ({count / seconds:.0f} per second), {tally['structured']} structured, "
        f"{tally['read']} read and carried on, {failed.total()} failed in {len(failed)} ways"
    )
    return failed.total()


def main() -> int:
    """Exit code 1 where an input failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000, help="inputs (default: 100000)")
    parser.add_argument("--seed", type=int, default=1, help="same seed, same inputs (default: 1)")
    parser.add_argument("--only", default="", help="one reader, by name")
    parser.add_argument(
        "--output", type=Path, default=ROOT / "out" / "fuzz", help="where failing inputs are kept"
    )
    options = parser.parse_args()
    np.seterr(all="ignore")
    return int(fuzz(options.count, options.seed, options.only, options.output) > 0)


if __name__ == "__main__":
    sys.exit(main())
