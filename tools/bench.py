"""Speed and memory, each beside what a user would otherwise use, in one run.

Every line is measured in a process of its own (`bench_cases.py`), on one core, in processor time: what else the
machine does then matters little. Still only the ratios in a table compare between machines. Takes come from the
data folder (see tests/conftest.py) where it is there, else from the procedural demo.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

# one core for every figure; must be said before numpy loads
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

from footwork.core import jobs
from footwork.core.database.build import build_database
from footwork.core.database.sidecar import save_database
from footwork.core.mocap.bvh import write_bvh
from footwork.core.mocap.demo import SCRIPTS, demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.takes import load_take
from footwork.core.settings import DatabaseSettings

DATA = Path(os.environ.get("FOOTWORK_DATA", Path(__file__).parents[2] / "shared" / "data"))
CASES = Path(__file__).with_name("bench_cases.py")
LIMIT_S = 1200.0


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a table."""

    what: str
    seconds: float | None
    """Processor time; None where it could not be measured."""
    peak_mb: float
    ratio: str
    """In words: times the first line of the table, or times real time."""


@dataclass(frozen=True, slots=True)
class Table:
    """Lines that belong together; `bar` is what the design asks for."""

    title: str
    rows: list[Row]
    bar: str = ""


def case(name: str, *arguments: object) -> dict[str, Any]:
    """Run one case in a process of its own; `{"seconds", "peak_mb", ...}`, or `{"missing": why}`."""
    command = [sys.executable, str(CASES), name, *map(str, arguments)]
    print(f"  {name} {' '.join(Path(str(a)).name for a in arguments)}", file=sys.stderr, flush=True)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return {"missing": f"not done after {LIMIT_S:.0f} s"}
    answers = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not answers:
        sys.exit(f"bench case {name} failed:\n{done.stderr[-3000:]}")
    return json.loads(answers[-1])


def beside(title: str, cases: dict[str, dict[str, Any]], bar: str = "") -> Table:
    """A table whose ratios are to its first line."""
    first = next(iter(cases.values()))["seconds"]
    rows: list[Row] = []
    for what, found in cases.items():
        if "missing" in found:
            rows.append(Row(what, None, 0.0, found["missing"]))
        else:
            rows.append(Row(what, found["seconds"], found["peak_mb"], f"{found['seconds'] / first:.2f}"))
    return Table(title, rows, bar)


def real_time(title: str, cases: dict[str, dict[str, Any]], bar: str = "") -> Table:
    """A table whose ratios are to the recorded time."""
    rows: list[Row] = []
    for what, found in cases.items():
        if "missing" in found:
            rows.append(Row(what, None, 0.0, found["missing"]))
            continue
        ratio = f"{found['recorded'] / found['seconds']:.0f} x real time{found.get('note', '')}"
        rows.append(Row(what, found["seconds"], found["peak_mb"], ratio))
    return Table(title, rows, bar)


def prepare(folder: Path) -> tuple[list[Path], Path, Path]:
    """Takes for a database, a take to read, and the user's take."""
    if DATA.is_dir():
        takes = DATA / "takes"
        return (
            sorted((takes / "lafan1").glob("*subject[12]*.bvh")),
            takes / "xsens/JL_mm_run.bvh",
            takes / "fubot_vr/spacepiratetrainer_0.bvh",
        )
    paths: list[Path] = []
    for seed, script in enumerate(SCRIPTS):
        paths.append(folder / f"{script}.bvh")
        write_bvh(paths[-1], to_bvh(demo_motion(script, seed), script))
    return paths[:-1], paths[0], paths[-1]


def run(folder: Path, quick: bool) -> list[Table]:
    """All tables."""
    takes, read, user = prepare(folder)
    database = folder / "database.npz"
    loaded = [load_take(path, 60.0) for path in takes]
    save_database(database, jobs.run(build_database(loaded, DatabaseSettings(mirror=True), name="bench")))
    frames = sum(len(take.motion) for take in loaded) * 2
    del loaded

    tables = [
        beside(
            f"Reading {read.name}",
            {
                "Footwork: read BVH": case("read", read),
                "Footwork: read, find roles, T-pose, floor": case("load", read),
                "upc-pymotion: read BVH": case("pymotion", read),
                "Blender: import BVH": case("blender-import", read),
            },
        ),
        real_time(
            f"Building a database from BVH text ({len(takes)} takes, mirrored)",
            {f"{frames / 1000:.0f} k frames": case("build", *takes)},
            "at least 100 x real time",
        ),
    ]
    for size in (25_000, 100_000) if quick else (25_000, 100_000, 250_000, 1_000_000):
        tables.append(
            beside(
                f"One exact search in {size // 1000} k frames",
                {
                    "Footwork": case("search", "ours", database, size),
                    "differences of all frames (numpy)": case("search", "differences", database, size),
                    "scipy cKDTree": case("search", "scipy", database, size),
                    "scikit-learn KDTree": case("search", "kdtree", database, size),
                    "scikit-learn BallTree": case("search", "balltree", database, size),
                },
            )
        )
    lengths = (1, 5) if quick else (1, 5, 15, 60)
    sizes = (25_000,) if quick else (25_000, 216_000, 500_000)
    rigs = (200,) if quick else (65, 200, 500)

    def bake(how: str, minutes: int, size: int = 0, bones: int = 0) -> dict[str, Any]:
        return case("bake", how, database, user, minutes, size, bones)

    for how, bar in (("greedy", 300), ("path", 20)):
        tables += [
            real_time(
                f"Bake with {how} search, before writing keys, by length of the recording",
                {f"{minutes} min": bake(how, minutes) for minutes in lengths},
                f"at least {bar} x real time",
            ),
            real_time(
                f"Bake of 5 min with {how} search, by size of the database",
                {f"{size // 1000} k frames": bake(how, 5, size) for size in sizes},
            ),
        ]
    tables.append(
        real_time(
            "Greedy bake of 5 min, by number of bones of the rig",
            {f"{bones} bones": bake("greedy", 5, 0, bones) for bones in rigs},
        )
    )
    if not quick:
        hour = {
            f"1 h recorded, 1 h in the database (216 k frames), {how}": bake(how, 60, 216_000)
            for how in ("greedy", "path")
        }
        tables.append(real_time("An hour with an hour", hour, "less than 4096 MB"))
    tables.append(
        beside(
            "Writing keys of 22 bones",
            {
                "Footwork: 5 min at 60 fps, 18000 frames": case("write", "bulk", 18_000, 22),
                "Footwork: 1000 frames": case("write", "bulk", 1000, 22),
                "keyframe_insert: 1000 frames": case("write", "insert", 1000, 22),
                "keyframe_insert: 200 frames": case("write", "insert", 200, 22),
            },
            "5 min in less than 1 s",
        )
    )
    tables.append(
        beside(
            "Writing keys of 5 min at 60 fps, by number of keyed bones",
            {f"{bones} bones": case("write", "bulk", 18_000, bones) for bones in (22, 44, 88)},
        )
    )
    return tables


def as_markdown(tables: list[Table]) -> str:
    """The tables for docs/performance.md."""
    lines: list[str] = []
    for table in tables:
        lines += [f"### {table.title}", ""]
        if table.bar:
            lines += [f"The bar: {table.bar}.", ""]
        lines += ["| | seconds | peak MB | ratio |", "|---|---|---|---|"]
        for row in table.rows:
            seconds = "" if row.seconds is None else f"{row.seconds:.3g}"
            peak = f"{row.peak_mb:.0f}" if row.peak_mb else ""
            lines.append(f"| {row.what} | {seconds} | {peak} | {row.ratio} |")
        lines.append("")
    return "\n".join(lines)


def main() -> None:
    """Run every bench and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="also write the tables here")
    parser.add_argument("--markdown", type=Path, help="and here as Markdown")
    parser.add_argument("--quick", action="store_true", help="small sizes only, a few minutes")
    options = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        tables = run(Path(folder), options.quick)
    for table in tables:
        print(f"\n{table.title}" + (f" (the bar: {table.bar})" if table.bar else ""))
        for row in table.rows:
            seconds = "-" if row.seconds is None else f"{row.seconds * 1000:.2f} ms"
            print(f"  {row.what:<46}{seconds:>16}{row.peak_mb:>9.0f} MB   {row.ratio}")
    print(f"\n{time.monotonic() - began:.0f} s")
    if options.json:
        options.json.write_text(json.dumps([asdict(table) for table in tables], indent=2))
    if options.markdown:
        options.markdown.write_text(as_markdown(tables))


if __name__ == "__main__":
    main()
