"""Seeded fuzzing of every reader and verb: whatever a file holds, it is used to the end, or refused with one line.

Two thirds of the inputs are sound files with changed values, shapes and counts; the others have changed bytes. An input
that is read is carried on to what a user wants of it: a take becomes a database, that is baked with, and the bake is
measured; a recording is baked; a predictor predicts for a bake; `fuzz_readers.py` has the list. Some inputs go through
the verbs of the command line instead (`fuzz_verbs.py`).

Only InputError may come of it. Reading or refusing takes at most a second; an input that was read may take longer for
the rest, since the work then is that of its content, not of its form. The process may grow by 300 MB at most, as the
system counts it. What fails is kept in out/fuzz.
"""

from __future__ import annotations

import argparse
import hashlib
import multiprocessing
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import numpy as np
from footwork.core.errors import LONGEST, InputError
from fuzz_changes import change_bytes
from fuzz_readers import Reader, readers
from fuzz_verbs import run_verb

ROOT = Path(__file__).parents[1]
READING_S, CARRYING_S, GROWTH, ADDRESSES = 1.0, 10.0, 300 << 20, 4 << 30
STRUCTURED, THROUGH_VERBS, CHUNK = 2 / 3, 0.04, 250
"""Shares of the inputs, and inputs that a process takes at once."""

state: list = []
"""Of a process: its folder, and its readers."""


class Peak:
    """The most memory that the process has had since, in bytes beyond what it had."""

    def __init__(self) -> None:
        Path("/proc/self/clear_refs").write_text("5")
        self.before = self._read("VmRSS")

    @staticmethod
    def _read(name: str) -> int:
        found = re.search(rf"{name}:\s+(\d+) kB", Path("/proc/self/status").read_text())
        assert found is not None
        return int(found[1]) * 1024

    def grown(self) -> int:
        """So far."""
        return self._read("VmHWM") - self.before


def tried(reader: Reader, path: Path, rng: random.Random) -> tuple[str, str]:
    """What becomes of an input: "refused", "read" (and refused later), "carried" or "verb N", and what is wrong."""
    peak, start = Peak(), time.process_time()
    reading_s, came = 0.0, "refused"
    signal.setitimer(signal.ITIMER_REAL, 60.0)
    try:
        if reader.verbs and rng.random() < THROUGH_VERBS:
            came = f"verb {run_verb(rng.choice(reader.verbs), path)}"
        else:
            value = reader.read(path)
            reading_s, came = time.process_time() - start, "read"
            reader.carry(value, path)
            came = "carried"
    except InputError as error:
        if not all(line.isprintable() and len(line) <= LONGEST for line in error.lines):
            return came, f"message {str(error)!r}"
    except Exception as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        return came, f"{type(error).__name__} at {Path(at.filename).name}:{at.lineno}: {error}"[:400]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    seconds, grown = time.process_time() - start, peak.grown()
    if grown > GROWTH:
        return came, f"{grown >> 20} MB"
    limit = READING_S if came in ("refused", "verb 2") else CARRYING_S
    if reading_s > READING_S or seconds > limit:
        return came, f"{seconds:.1f} s"
    return came, ""


def give_up(*_: object) -> None:
    """A minute is more than slow."""
    raise TimeoutError("takes more than a minute")


def prepare(folder: Path, only: str) -> None:
    """Get a process ready: its readers, and limits that keep the machine alive."""
    np.seterr(all="ignore")
    place = Path(tempfile.mkdtemp(dir=folder))
    kinds = [reader for reader in readers(place) if only in ("", reader.name)]
    for reader in kinds:
        path = (place / "sound").with_suffix(reader.suffix)
        path.write_bytes(reader.sound)
        reader.carry(reader.read(path), path)
        for verb in reader.verbs:
            code = run_verb(verb, path)
            assert code == 0, (reader.name, verb, code)
    state[:] = [place, kinds]
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, resource.getrlimit(resource.RLIMIT_AS)[1]))
    signal.signal(signal.SIGALRM, give_up)


def some(job: tuple[int, int, int]) -> tuple[Counter[tuple[str, str, str]], list[tuple[str, bytes]]]:
    """Try the inputs of a range of numbers: how often what happened, and what failed."""
    seed, first, end = job
    place, kinds = state
    tally: Counter[tuple[str, str, str]] = Counter()
    failed: list[tuple[str, bytes]] = []
    for number in range(first, end):
        rng = random.Random(f"{seed} {number}")
        reader = kinds[number % len(kinds)]
        structured = rng.random() < STRUCTURED
        content = (reader.change if structured else change_bytes)(rng, reader.sound)
        path = (place / "input").with_suffix(reader.suffix)
        path.write_bytes(content)
        came, fault = tried(reader, path, rng)
        tally[reader.name, "structured" if structured else "bytes", came] += 1
        if fault:
            digest = hashlib.sha256(content).hexdigest()[:8]
            name = f"{reader.name.replace(' ', '_')}_{number}_{digest}{reader.suffix}"
            failed.append((f"{name}: {came}: {fault}", content))
    return tally, failed


def fuzz(count: int, seed: int, only: str, output: Path, jobs: int) -> int:
    """Try `count` inputs; the number that failed."""
    tally: Counter[tuple[str, str, str]] = Counter()
    failed, start = 0, time.perf_counter()
    chunks = [(seed, first, min(first + CHUNK, count)) for first in range(0, count, CHUNK)]
    with tempfile.TemporaryDirectory() as folder:
        spawn = multiprocessing.get_context("spawn")
        with spawn.Pool(jobs, prepare, (Path(folder), only)) as pool:
            for found, faults in pool.imap_unordered(some, chunks):
                tally += found
                failed += len(faults)
                for line, content in faults:
                    output.mkdir(parents=True, exist_ok=True)
                    (output / line.partition(":")[0]).write_bytes(content)
                    print(line, flush=True)
    tell(tally, time.perf_counter() - start, failed)
    return failed


def tell(tally: Counter[tuple[str, str, str]], seconds: float, failed: int) -> None:
    """What was done, kind by kind, and what counts."""
    heads = ("inputs", "structured", "refused", "read", "carried", "verb 0", "verb 2", "verb 3")
    print(f"{'':12}" + "".join(f"{head:>11}" for head in heads))

    def row(name: str) -> list[int]:
        mine = {key: n for key, n in tally.items() if name in (key[0], "all")}
        outcomes = [sum(n for key, n in mine.items() if key[2] == head) for head in heads[2:]]
        return [
            sum(mine.values()),
            sum(n for key, n in mine.items() if key[1] == "structured"),
            *outcomes,
        ]

    for name in (*dict.fromkeys(key[0] for key in sorted(tally)), "all"):
        print(f"{name:12}" + "".join(f"{number:11}" for number in row(name)))
    count, structured, _, _, carried, done, *_ = row("all")
    whole = sum(n for key, n in tally.items() if key[1] == "structured" and key[2] in ("carried", "verb 0"))
    print(
        "read: refused later on the way; carried: through the reader and all that follows, without a fault; "
        "verb N: through a verb of the command line, which ended with code N\n"
        f"limits: {READING_S:g} s for reading or refusing, {CARRYING_S:g} s for an input that was read and is carried "
        f"to the end, {GROWTH >> 20} MB of resident memory at the peak of each input\n"
        f"{count} inputs in {seconds:.0f} s ({count / seconds:.0f} per second), {structured} structured; structurally "
        f"valid and carried to the end: {carried + done} ({(carried + done) / count:.1%}), of them {whole} structured; "
        f"{failed} failed"
    )


def main() -> int:
    """Exit code 1 where an input failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000, help="inputs (default: 100000)")
    parser.add_argument("--seed", type=int, default=1, help="same seed, same inputs (default: 1)")
    parser.add_argument("--only", default="", help="one reader, by name")
    parser.add_argument(
        "--jobs",
        type=int,
        default=len(os.sched_getaffinity(0)),
        help="processes (default: one for each core)",
    )
    parser.add_argument(
        "--output", type=Path, default=ROOT / "out" / "fuzz", help="where failing inputs are kept"
    )
    options = parser.parse_args()
    return int(fuzz(options.count, options.seed, options.only, options.output, options.jobs) > 0)


if __name__ == "__main__":
    sys.exit(main())
