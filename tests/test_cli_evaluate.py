"""`evaluate` and `compare-reports` as a script would use them: report folder, schema, limits, exit codes."""

from __future__ import annotations

import base64
import importlib.util
import json
import re
import subprocess
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from footwork.cli import main

SCHEMA = json.loads(
    (Path(__file__).parents[1] / "docs" / "evaluation.schema.json").read_text(encoding="utf-8")
)
WITH_BPY = importlib.util.find_spec("bpy") is not None
GREEDY = ["--search", "greedy"]


@pytest.fixture(scope="module")
def walk(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small database of the demo."""
    target = tmp_path_factory.mktemp("evaluate") / "walk.npz"
    assert (
        main(["build-database", *(str(demo / f"{n}.bvh") for n in ("walk", "turn")), "-o", str(target)]) == 0
    )
    return target


@pytest.fixture(scope="module")
def folder(demo: Path, walk: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of two takes with the experiment that needs no bake."""
    out = tmp_path_factory.mktemp("report") / "new" / "folder"
    takes = [str(demo / f"{name}.bvh") for name in ("visit", "sidestep")]
    arguments = ["--database", str(walk), "--experiment", "orientation", "-o", str(out)]
    assert main(["evaluate", *takes, *arguments, *GREEDY, "--fail-if", "root_error_cm.max > 1000"]) == 0
    return out


class Page(HTMLParser):
    """What a page loads, shows and how its tags nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sources: list[str] = []
        self.words = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "img"):
            self.open.append(tag)
        self.sources += [value or "" for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words += data


def test_the_report_follows_its_schema(folder: Path) -> None:
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.validate(report, SCHEMA)
    assert [Path(entry["take"]).stem for entry in report["takes"]] == ["visit", "sidestep"]
    assert all(re.fullmatch("[0-9a-f]{64}", row["sha256"]) for row in report["inputs"])
    assert report["limits"] == ["root_error_cm.max > 1000"] and report["failed"] == []
    seconds = report["takes"][0]["timing_s"]["recorded"]
    assert abs(len(report["takes"][0]["series"]["root_error_cm"]) - seconds) <= 1.0


def test_the_schema_refuses_what_is_no_report(folder: Path) -> None:
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    for change in (
        lambda r: r.pop("metrics"),
        lambda r: r["metrics"]["root_error_cm"].pop("p95"),
        lambda r: r.update(schema=1),
        lambda r: r["takes"].clear(),
        lambda r: r["metrics"].update(clamped_fraction=1.5),
    ):
        broken = json.loads(json.dumps(report))
        change(broken)
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(broken, SCHEMA)


def test_pooled_figures_lie_between_those_of_the_takes(folder: Path) -> None:
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    for name, value in report["metrics"].items():
        parts = [entry["metrics"][name] for entry in report["takes"]]
        if isinstance(value, dict) and value["count"]:
            means = [part["mean"] for part in parts]
            assert min(means) - 1e-4 <= value["mean"] <= max(means) + 1e-4, name
            assert value["count"] == sum(part["count"] for part in parts), name
            assert value["max"] == pytest.approx(max(part["max"] for part in parts), rel=1e-5), name
        elif name == "poses_used":
            assert max(parts) <= value <= sum(parts)


def test_the_page_holds_everything_in_itself(folder: Path) -> None:
    page = Page((folder / "report.html").read_text(encoding="utf-8"))
    assert page.open == []
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert "foot_skate_cm_s" in page.words and "Body orientation" in page.words and "visit.bvh" in page.words
    assert "None of these: root_error_cm.max > 1000" in page.words
    if importlib.util.find_spec("matplotlib"):
        pictures = [base64.b64decode(source.split(",")[1]) for source in page.sources]
        assert len(pictures) == 3 and all(picture.startswith(b"\x89PNG") for picture in pictures)
        assert {path.name for path in folder.glob("*.png")} == {
            "orientation.png",
            "visit.png",
            "sidestep.png",
        }


def test_without_matplotlib_the_tables_still_come(
    demo: Path,
    walk: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "footwork.cli.figures", raising=False)
    arguments = ["--database", str(walk), "-o", str(tmp_path), *GREEDY]
    assert main(["evaluate", str(demo / "sidestep.bvh"), *arguments]) == 0
    assert "matplotlib" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "report.json"]
    assert "foot skate" in Page((tmp_path / "report.html").read_text(encoding="utf-8")).words


def test_errors_of_predictors_as_table_report_and_picture(
    demo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    figures = pytest.importorskip("footwork.cli.figures", reason="matplotlib is not installed")
    drawn: list[Any] = []
    monkeypatch.setattr(figures, "_png", lambda figure: drawn.append(figure) or b"a picture")
    takes = [str(demo / f"{name}.bvh") for name in ("visit", "walk", "turn")]
    plot = tmp_path / "errors.png"
    assert main(["evaluate-predictor", *takes, "--plot", str(plot), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    jsonschema.validate(report, {"$ref": "#/$defs/predictors", "$defs": SCHEMA["$defs"]})
    assert plot.read_bytes() == b"a picture"
    ((left, right),) = (figure.axes for figure in drawn)
    for row, minutes in zip(report["predictors"].values(), left.lines, strict=True):
        (shown,) = minutes.get_ydata()
        assert shown == row["per_minute"][0] == pytest.approx(row["mean"]), "the demo is less than a minute"
        assert f"{row['mean']:.1f}°" in minutes.get_label()
    for row, curve, dot in zip(
        report["predictors"].values(), right.lines[::2], right.lines[1::2], strict=True
    ):
        at = curve.get_ydata() == 95.0
        assert curve.get_xdata()[at] == pytest.approx(row["p95"])
        assert dot.get_xdata() == pytest.approx(row["mean"])


@pytest.mark.parametrize(("seconds", "middles"), [(130.0, [0.5, 1.5]), (150.0, [0.5, 1.5, 2.25])])
def test_minutes_are_drawn_in_their_middle_and_a_last_short_one_not_at_all(
    seconds: float, middles: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    figures = pytest.importorskip("footwork.cli.figures", reason="matplotlib is not installed")
    drawn: list[Any] = []
    monkeypatch.setattr(figures, "_png", drawn.append)
    row = {"mean": 9.0, "per_minute": [7.0, 8.0, 30.0], "percentiles": [i / 5 for i in range(101)]}
    figures.draw_predictors({"predictors": {"mine": row}, "takes": [{"seconds": seconds}]})
    (line,) = drawn[0].axes[0].lines
    assert line.get_xdata() == pytest.approx(middles)
    assert line.get_ydata() == pytest.approx(row["per_minute"][: len(middles)])


def test_a_picture_is_a_png_and_needs_matplotlib(
    demo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["evaluate-predictor", str(demo / "turn.bvh"), "--plot"]
    assert main([*command, str(tmp_path / "errors.pdf")]) == 2
    assert "end in .png" in capsys.readouterr().err
    plot = tmp_path / "errors.png"
    if importlib.util.find_spec("matplotlib"):
        assert main([*command, str(plot)]) == 0
        assert plot.read_bytes().startswith(b"\x89PNG")
        plot.unlink()
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "footwork.cli.figures", raising=False)
    capsys.readouterr()
    assert main([*command, str(plot), "--json", str(tmp_path / "errors.json")]) == 2
    assert "pip install matplotlib" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_limit_that_is_passed_ends_with_three_and_still_reports(
    demo: Path, walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "report.json"
    limits = ["--fail-if", "transitions_per_s >= 0", "--fail-if", "root_error_cm.max > 1000"]
    arguments = ["--database", str(walk), "--json", str(target), *GREEDY]
    assert main(["evaluate", str(demo / "sidestep.bvh"), *arguments, *limits]) == 3
    assert "failed: transitions_per_s >= 0" in capsys.readouterr().err
    report = json.loads(target.read_text(encoding="utf-8"))
    jsonschema.validate(report, SCHEMA)
    assert len(report["failed"]) == 1


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--fail-if", "foot_skate.mean > 2"], "no metric"),
        (["--fail-if", "x", "--fail-if", "y"], "'y'"),
        (["--against", "absent.json"], "absent.json"),
        (["--experiment", "leg-bend"], "two databases"),
        (["--experiment", "no-such"], "invalid choice"),
    ],
)
def test_bad_use_ends_with_two_and_writes_nothing(
    demo: Path,
    walk: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    told: str,
) -> None:
    out = tmp_path / "report"
    command = ["evaluate", str(demo / "sidestep.bvh"), "--database", str(walk), "-o", str(out), *GREEDY]
    assert main([*command, *arguments]) == 2
    assert told in capsys.readouterr().err
    assert not out.exists()


def test_a_take_that_is_in_the_database_is_told(
    demo: Path, walk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", str(demo / "turn.bvh"), "--database", str(walk), *GREEDY, "--json", "-"]) == 0
    told = capsys.readouterr()
    assert "turn is in the database walk" in told.err
    assert json.loads(told.out)["warnings"]


def test_reports_are_compared(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    report["metrics"]["mpjpe_cm"]["mean"] *= 0.5
    old, new = tmp_path / "old.json", folder / "report.json"
    old.write_text(json.dumps(report), encoding="utf-8")
    assert main(["compare-reports", str(new), str(new), "--fail-if-worse"]) == 0
    assert main(["compare-reports", str(old), str(new)]) == 0
    assert (
        main(["compare-reports", str(old), str(new), "--fail-if-worse", "--json", str(tmp_path / "c.json")])
        == 3
    )
    comparison = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    assert comparison["failed"] == ["mpjpe_cm.mean got worse"]
    assert main(["compare-reports", str(new), str(old), "--fail-if-worse"]) == 0, "better is no failure"
    (tmp_path / "text.json").write_text("no report", encoding="utf-8")
    (tmp_path / "other.json").write_text("{}", encoding="utf-8")
    capsys.readouterr()
    assert main(["compare-reports", str(tmp_path / "text.json"), str(tmp_path / "other.json")]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 2


def test_an_evaluation_beside_an_earlier_one(demo: Path, walk: Path, folder: Path, tmp_path: Path) -> None:
    command = ["evaluate", str(demo / "sidestep.bvh"), "--database", str(walk), *GREEDY]
    assert main([*command, "--against", str(folder / "report.json"), "-o", str(tmp_path)]) == 0
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    jsonschema.validate(report, SCHEMA)
    assert any("visit.bvh" in line for line in report["comparison"]["differences"])
    assert "Against an earlier report" in Page((tmp_path / "report.html").read_text(encoding="utf-8")).words


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_blender_shows_what_the_core_computed(demo: Path, walk: Path, tmp_path: Path) -> None:
    """The baked action on an armature, through Blender's depsgraph: within 1 mm and 0.1 degree of our own result."""
    command = [
        sys.executable,
        "-m",
        "footwork",
        "evaluate",
        str(demo / "sidestep.bvh"),
        "--database",
        str(walk),
    ]
    reports: list[dict[str, Any]] = []
    run: Callable[..., Any] = subprocess.run
    for more in ([], ["--in-blender"]):
        target = tmp_path / f"report{len(reports)}.json"
        done = run(
            [*command, *GREEDY, *more, "--json", str(target)], capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        reports.append(json.loads(target.read_text(encoding="utf-8")))
        jsonschema.validate(reports[-1], SCHEMA)
    agreement = reports[1]["takes"][0]["agreement"]
    assert agreement["position_mm"] < 1.0 and agreement["rotation_deg"] < 0.1
    for name, value in reports[0]["metrics"].items():
        if name.endswith(("_cm", "_deg")):
            assert reports[1]["metrics"][name]["mean"] == pytest.approx(value["mean"], abs=0.1), name
