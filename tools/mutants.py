"""Mutation testing: how many small faults, put into a package one at a time, do that package's own tests notice?

mutmut makes the faults and runs, for each, the tests that call the changed function. It wants the package in a folder
of its name, so it works on a copy in a temporary folder. What it does not kill is run once more against all tests of
the package in a fresh process: mutmut credits what a shared fixture calls to one test alone, forks after test modules
were imported, and takes a busy machine for an endless loop. Real motion data is hidden from the tests, so the score is
the same on every machine.

What does not count is said in `RULES` and counted in the table. mutmut never changes: texts of `raise`, docstrings,
annotations, decorated functions (properties, cached ones), constants of modules, and calls of `len` and `isinstance`.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import difflib
import fnmatch
import io
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
import time
import tokenize
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("maths", "body", "database", "matching", "rig", "recording")
WANTED = 0.85
NOT_COPIED = ("tests", "docs", "build", "dist", "out", "shared", "__pycache__", "*.egg-info", ".*")
SETTINGS = r"""
[tool.mutmut]
source_paths = ["footwork"]
only_mutate = ["footwork/core/{package}/*"]
also_copy = ["docs", "without_shrinking.py"]
pytest_add_cli_args = {arguments}
pytest_add_cli_args_test_selection = ["tests/core/{package}"]
do_not_mutate_patterns = ['^\s*raise\b']
use_git_change_detection = false
process_isolation = "forkserver"
timeout_constant = 10.0
timeout_multiplier = 5.0
"""
ARGUMENTS = ["-p", "no:cacheprovider", "-p", "without_shrinking", "--hypothesis-profile=without_shrinking"]
PROFILE = """
from hypothesis import HealthCheck, Phase, settings

settings.register_profile(
    "without_shrinking",
    phases=[Phase.explicit, Phase.generate],  # that a test fails is enough; the simplest example takes long to find
    derandomize=True, deadline=None, database=None, suppress_health_check=[HealthCheck.too_slow],
)
"""


@dataclass(frozen=True, slots=True)
class Mutant:
    """One fault: mutmut's name for it, where it is, and the lines without and with it."""

    name: str
    path: str
    line: int
    before: tuple[str, ...]
    after: tuple[str, ...]
    excluded: str = ""
    """Why it does not count, or nothing."""

    def __str__(self) -> str:
        lines = [f"{self.path}:{self.line}  {self.name}"]
        lines += [f"  - {line.strip()}" for line in self.before] + [
            f"  + {line.strip()}" for line in self.after
        ]
        return "\n".join(lines)


@dataclass(slots=True)
class Score:
    """What became of the mutants of one package: those there are, those tried, and what each came to."""

    package: str
    known: int
    excluded: Counter[str]
    fates: dict[Mutant, str] = field(default_factory=dict)
    seconds: float = 0.0

    def count(self, fate: str) -> int:
        """How many came to `killed`, `timeout` or `survived`."""
        return sum(value == fate for value in self.fates.values())

    @property
    def share(self) -> float:
        """Share of the tried that were noticed; a test that no longer ends has noticed."""
        return (self.count("killed") + self.count("timeout")) / max(len(self.fates), 1)

    @property
    def error(self) -> float:
        """Standard error of the share, for a sample drawn from finitely many."""
        tried, left = len(self.fates), self.known - len(self.fates)
        return math.sqrt(self.share * (1 - self.share) / max(tried, 1) * left / max(self.known - 1, 1))


def tokens(source: str) -> list[str]:
    """The words and signs of some code, without comments, blanks and line ends."""
    skipped = {
        tokenize.COMMENT,
        tokenize.NL,
        tokenize.NEWLINE,
        tokenize.INDENT,
        tokenize.DEDENT,
        tokenize.ENDMARKER,
    }
    read = tokenize.generate_tokens(io.StringIO(source).readline)
    return [token.string for token in read if token.type not in skipped]


def why_excluded(before: str, after: str) -> str:
    """The rule by which a change of a function is none of behaviour, or nothing."""
    old, new = tokens(before), tokens(after)
    first, gone, come = changed(old, new)
    around = "".join(old[max(first - 2, 0) : first + len(gone) + 2])
    line = changed(before.split("\n"), after.split("\n"))[1]
    edit = Edit("".join(gone), "".join(come), around, line[0].strip() if line else "")
    return next((name for name, rule in RULES.items() if rule(edit)), "")


@dataclass(frozen=True, slots=True)
class Edit:
    """What a mutant replaces by what, in code without blanks; two words more on each side; the line."""

    gone: str
    come: str
    around: str
    line: str


PROSE = re.compile(r"""(["']).*\w .*\1""")
RULES: dict[str, Callable[[Edit], object]] = {
    # a text for people (a string with a blank in it) is spelt otherwise
    "text": lambda edit: PROSE.fullmatch(edit.gone) and PROSE.fullmatch(edit.come),
    # zip's own guard against unequal lengths, which sound callers cannot reach
    "strict": lambda edit: (
        "strict=True" in edit.around and edit.gone in ("True", "strict=True", ",strict=True")
    ),
    # typing.cast returns its second argument whatever the first is
    "cast": lambda edit: edit.around.startswith("cast(") and re.match("None$|[\"']", edit.come),
    # where numpy puts a result, which is the same result: order=, and out= where the result is assigned as well
    "memory": lambda edit: (
        (re.search(r"\border=", edit.around) and re.fullmatch(r'(order=)?"\w"', edit.gone))
        or (
            re.match(r"\w+ \S?= .*\bout=", edit.line)
            and re.search(r"\bout=", edit.around)
            and re.fullmatch(r"(out=)?\w+", edit.gone)
        )
    ),
    # names that mean the same in capitals: einsum's axes, the encoding
    "capitals": lambda edit: (
        edit.gone.lower() == edit.come.lower() and re.search(r"->|(?i:utf-8)", edit.gone)
    ),
}


def changed(before: list[str], after: list[str]) -> tuple[int, list[str], list[str]]:
    """Index of the first changed item, and the changed items on both sides."""
    edits = [e for e in difflib.SequenceMatcher(None, before, after, False).get_opcodes() if e[0] != "equal"]
    first, last = edits[0], edits[-1]
    return first[1], before[first[1] : last[2]], after[first[3] : last[4]]


def functions(tree: ast.AST, inside: str = "") -> Iterator[tuple[str, ast.FunctionDef]]:
    """Functions and methods by mutmut's names for them: `x_name`, or `xǁClassǁname`."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            known = node.name.startswith(("x_", "xǁ")) and "__mutmut_" in node.name
            yield node.name if known else f"xǁ{inside}ǁ{node.name}" if inside else f"x_{node.name}", node
        elif isinstance(node, ast.ClassDef) and not inside:
            yield from functions(node, node.name)


def mutants_of(path: str, source: str, mutated: str) -> list[Mutant]:
    """The mutants that mutmut wrote beside the functions of one module."""
    lines = mutated.splitlines()
    starts = {name: node.lineno for name, node in functions(ast.parse(source))}
    code = {
        name: lines[node.lineno - 1 : node.end_lineno]
        for name, node in functions(ast.parse(mutated))
        if "__mutmut_" in name
    }
    module = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    found: list[Mutant] = []
    for name, body in code.items():
        function, _, number = name.partition("__mutmut_")
        if not number.isdigit():
            continue
        whole = [code[f"{function}__mutmut_orig"], body]
        texts = [textwrap.dedent("\n".join(text)).replace(f"{function}__mutmut_", "") for text in whole]
        texts = [re.sub(r"^def \w+", "def f", text) for text in texts]
        offset, before, after = changed(*(text.split("\n") for text in texts))
        where = (f"footwork.{module}.{name}", path, starts[function] + offset)
        found.append(Mutant(*where, tuple(before), tuple(after), why_excluded(*texts)))
    return found


def copy(folder: Path, package: str) -> None:
    """Lay out Footwork as mutmut wants it."""
    shutil.copytree(ROOT, folder / "footwork", ignore=shutil.ignore_patterns(*NOT_COPIED))
    for name in ("tests", "docs"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "mutants").mkdir()  # mutmut's copy with the mutants: on the path from the start
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    settings = SETTINGS.format(package=package, arguments=ARGUMENTS)
    (folder / "pyproject.toml").write_text(project + settings, encoding="utf-8")
    for place in (folder, folder / "mutants"):
        (place / "without_shrinking.py").write_text(PROFILE, encoding="utf-8")


def all_mutants(folder: Path, package: str) -> list[Mutant]:
    """Every mutant of a package, in the order of their names."""
    from mutmut.mutation.file_mutation import mutate_file_contents

    found: list[Mutant] = []
    with contextlib.chdir(folder):  # mutmut reads its settings there
        for file in sorted((folder / "footwork" / "core" / package).rglob("*.py")):
            path = file.relative_to(folder / "footwork").as_posix()
            source = file.read_text(encoding="utf-8")
            found += mutants_of(path, source, mutate_file_contents(f"footwork/{path}", source).code)
    return sorted(found, key=lambda mutant: mutant.name)


def environment(folder: Path) -> dict[str, str]:
    """One thread for each process, the copy before anything installed, and no motion data."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    return {
        **os.environ,
        **threads,
        "PYTHONPATH": str(folder / "mutants"),
        "PYTHONDONTWRITEBYTECODE": "1",
        "FOOTWORK_DATA": str(folder / "no data"),
    }


def by_mutmut(folder: Path, names: list[str], workers: int, log: Path) -> dict[str, str]:
    """What mutmut makes of each mutant."""
    mutmut = str(Path(sys.executable).with_name("mutmut"))
    command = [mutmut, "run", "--max-children", str(workers), *names]
    with log.open("w", encoding="utf-8") as out:
        done = subprocess.run(
            command, cwd=folder, env=environment(folder), stdout=out, stderr=out, check=False
        )
    if done.returncode:
        raise SystemExit(f"mutmut failed with {done.returncode}: see {log}")
    command = [mutmut, "results", "--all", "true"]
    listed = subprocess.run(
        command, cwd=folder, env=environment(folder), capture_output=True, text=True, check=True
    )
    pairs = (line.strip().split(": ", 1) for line in listed.stdout.splitlines() if ": " in line)
    return {name: fate for name, fate in pairs if name in set(names)}


def in_fresh_process(folder: Path, package: str, name: str, limit: float) -> str:
    """What all tests of the package make of a mutant, from the import on; `` for the code as it is."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", *ARGUMENTS, f"tests/core/{package}"]
    env = {**environment(folder), "MUTANT_UNDER_TEST": name}
    try:
        place = folder / "mutants"
        done = subprocess.run(command, cwd=place, env=env, capture_output=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return "timeout"
    return "killed" if done.returncode else "survived"


def judge(folder: Path, package: str, chosen: list[Mutant], workers: int, log: Path) -> dict[Mutant, str]:
    """The fate of each chosen mutant: `killed`, `timeout` or `survived`."""
    fates = by_mutmut(folder, [mutant.name for mutant in chosen], workers, log)
    began = time.monotonic()
    if in_fresh_process(folder, package, "", 600.0) != "survived":
        raise SystemExit(f"the tests of {package} fail without any mutant")
    limit = 30.0 + 10.0 * (time.monotonic() - began)
    doubtful = [mutant for mutant in chosen if fates[mutant.name] != "killed"]
    with ThreadPoolExecutor(workers) as pool:
        again = pool.map(lambda mutant: in_fresh_process(folder, package, mutant.name, limit), doubtful)
        return {**dict.fromkeys(chosen, "killed"), **dict(zip(doubtful, again, strict=True))}


def choose(mutants: list[Mutant], package: str, count: int | None, seed: int) -> list[Mutant]:
    """A sample that is the same for the same code and seed, or all."""
    if count is None or count >= len(mutants):
        return mutants
    return random.Random(f"{seed}:{package}").sample(mutants, count)


def survivors_of(file: Path) -> set[str]:
    """Names of the mutants in an earlier list of survivors."""
    if not file.exists():
        return set()
    return set(re.findall(r"^\S+:\d+  (\S+)$", file.read_text(encoding="utf-8"), re.MULTILINE))


def examine(package: str, options: argparse.Namespace) -> Score:
    """Draw, run and write down the mutants of one package."""
    began = time.monotonic()
    listed = options.output / f"{package}.txt"
    with tempfile.TemporaryDirectory(prefix="footwork-mutants-") as name:
        folder = Path(name).resolve()
        copy(folder, package)
        every = all_mutants(folder, package)
        counted = [m for m in every if not m.excluded and fnmatch.fnmatchcase(m.name, options.like)]
        if options.again:
            earlier = survivors_of(listed)
            counted = [mutant for mutant in counted if mutant.name in earlier]
        score = Score(package, len(counted), Counter(m.excluded for m in every if m.excluded))
        chosen = choose(counted, package, None if options.all else options.sample, options.seed)
        if chosen:
            score.fates = judge(folder, package, chosen, options.workers, options.output / f"{package}.log")
    alive = sorted(
        (m for m, fate in score.fates.items() if fate == "survived"), key=lambda m: (m.path, m.line)
    )
    listed.write_text("\n\n".join(map(str, alive)) + "\n", encoding="utf-8")
    score.seconds = time.monotonic() - began
    return score


def table(scores: Iterable[Score]) -> str:
    """The scores in columns."""
    heads = (
        "package",
        "mutants",
        "excluded",
        "tried",
        "killed",
        "timeout",
        "survived",
        "score",
        "+-",
        "seconds",
    )
    rows = [heads]
    for s in scores:
        counts = (s.known, s.excluded.total(), len(s.fates), *map(s.count, ("killed", "timeout", "survived")))
        shares = (f"{100 * s.share:.1f} %", f"{100 * s.error:.1f}", f"{s.seconds:.0f}")
        rows.append((s.package, *map(str, counts), *shares))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.rjust, row, widths)) for row in rows)


def main() -> int:
    """Examine the packages asked for; 1 if one of them has too low a score."""
    there = [package for package in PACKAGES if (ROOT / "core" / package).is_dir()]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument(
        "packages", nargs="*", default=there, help="packages of core (all the contract names)"
    )
    parser.add_argument("--sample", type=int, default=200, help="mutants drawn from each package (200)")
    parser.add_argument("--all", action="store_true", help="every mutant: hours")
    parser.add_argument("--seed", type=int, default=0, help="another sample (0)")
    parser.add_argument("--like", default="*", help="only mutants of such names, e.g. '*.rig.arms.*'")
    parser.add_argument("--again", action="store_true", help="only what survived the last run, from its list")
    parser.add_argument("--show", action="store_true", help="print the survivors as well")
    parser.add_argument(
        "--workers", type=int, default=os.cpu_count() or 1, help="processes at a time (all cores)"
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=ROOT / "out" / "mutants", help="folder for lists and logs"
    )
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    scores: list[Score] = []
    for package in options.packages:
        scores.append(examine(package, options))
        print(f"{table(scores[-1:])}\n  excluded: {dict(scores[-1].excluded)}", flush=True)
        if options.show:
            print((options.output / f"{package}.txt").read_text(encoding="utf-8"))
    print(f"\n{table(scores)}\n\nSurvivors as diffs: {options.output}/PACKAGE.txt")
    low = [s.package for s in scores if s.fates and s.share < WANTED]
    if low:
        print(f"Below {100 * WANTED:.0f} %: {', '.join(low)}")
    return 1 if low else 0


if __name__ == "__main__":
    sys.exit(main())
