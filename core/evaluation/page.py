"""An evaluation's report as one self-contained HTML page."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from ..measure.catalogue import METRICS
from ..measure.metric import STATISTICS

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 72rem; margin: 2rem auto;
  padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { margin-top: 2.5rem; border-bottom: 2px solid #ddd; } h3 { margin-top: 1.8rem; }
table { border-collapse: collapse; margin: 1rem 0; font-size: 0.88rem; display: block; overflow-x: auto; }
th, td { padding: 0.25rem 0.6rem; border-bottom: 1px solid #e4e4e4; text-align: right; }
th { vertical-align: bottom; background: #f5f5f5; }
th:first-child, td:first-child, th:nth-child(9):last-child { text-align: left; }
td { white-space: nowrap; }
td.says { white-space: normal; text-align: left; min-width: 16rem; color: #666; font-size: 0.82rem; }
img { max-width: 100%; display: block; margin: 1rem 0; }
.yes, .better { color: #17692e; } .no, .worse { color: #a31515; font-weight: 600; }
.note { color: #666; } .warning { background: #fff4d6; padding: 0.3rem 0.6rem; }
"""


def page(
    report: Mapping[str, Any], figures: Mapping[str, Sequence[tuple[str, bytes]]], notes: Sequence[str] = ()
) -> str:
    """The page.

    Args:
        report: of `evaluate_takes`, with `experiments` and, where there is one, `comparison`.
        figures: title and PNG of each figure, by the name of its experiment, or of its take.
        notes: lines for the page's head.
    """
    takes = report["takes"]
    seconds = report["timing_s"]["recorded"]
    people = "1 take" if len(takes) == 1 else f"{len(takes)} takes"
    source = "the true body orientation" if report["true_orientation"] else "predicted body orientation"
    parts = [
        "<h1>Footwork evaluation</h1>",
        f"<p>{people}, {seconds:.0f} s; {source}; measured "
        f"{'on the rig as Blender evaluates it' if report['measured'] == 'in Blender' else 'on the core result'}; "
        f"{escape(report['producer'])}.</p>",
        *(f'<p class="warning">{escape(line)}</p>' for line in (*report["warnings"], *notes)),
        _limits(report),
        "<h2>All takes</h2>",
        _metrics_table(report["metrics"]),
        *(_experiment(entry, figures.get(entry["name"], ())) for entry in report["experiments"]),
        _comparison(report.get("comparison")),
        "<h2>Each take</h2>",
        *(_take(entry, figures.get(entry["take"], ())) for entry in takes),
        "<h2>Made from</h2>",
        _table(
            ["", "name", "SHA-256"],
            [[row["kind"], row["name"], row["sha256"]] for row in report["inputs"]],
        ),
        _table(["setting", "value"], [[key, str(value)] for key, value in report["settings"].items()]),
    ]
    head = f'<meta charset="utf-8"><title>Footwork evaluation</title><style>{STYLE}</style>'
    return (
        f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n'
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def shown(value: object) -> str:
    """A cell: numbers with as many digits as tell something."""
    if value is None:
        return ""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ")
    size = abs(value)
    return f"{value:.0f}" if size >= 1000.0 else f"{value:.1f}" if size >= 10.0 else f"{value:.2f}"


def _table(columns: Sequence[str], rows: Sequence[Sequence[object]], kinds: Sequence[str] = ()) -> str:
    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    body: list[str] = []
    for i, row in enumerate(rows):
        cells = "".join(f"<td>{escape(shown(cell))}</td>" for cell in row)
        body.append(f'<tr class="{kinds[i]}">{cells}</tr>' if kinds else f"<tr>{cells}</tr>")
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(body)}</tbody></table>"


def _metrics_table(metrics: Mapping[str, Any]) -> str:
    """Every metric with its statistics, its floor in the true motion, and what it is."""
    columns = ["", "unit", *STATISTICS, "floor", "floor p95", "what it is"]
    head = "".join(f"<th>{column}</th>" for column in columns)
    rows: list[str] = []
    for name, metric in METRICS.items():
        if name not in metrics:
            continue
        value = metrics[name]
        cells: list[object] = [metric.label, metric.unit]
        if metric.kind != "distribution":
            cells += [value, None, None, None, metrics.get(f"{name}_floor"), None]
        elif value["count"] == 0:
            cells += ["none", None, None, None, None, None]
        else:
            floor = value.get("floor", {})
            cells += [*(value[key] for key in STATISTICS), floor.get("mean"), floor.get("p95")]
        texts = "".join(f"<td>{escape(shown(cell))}</td>" for cell in cells)
        rows.append(f'<tr>{texts}<td class="says">{escape(metric.says)} <code>{name}</code></td></tr>')
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _figures(figures: Sequence[tuple[str, bytes]]) -> str:
    return "".join(
        f'<img alt="{escape(title)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'
        for title, png in figures
    )


def _experiment(entry: Mapping[str, Any], figures: Sequence[tuple[str, bytes]]) -> str:
    relations = "".join(
        f'<li><span class="{"yes" if r["holds"] else "no"}">{"holds" if r["holds"] else "does not hold"}</span>: '
        f"{escape(r['claim'])} ({escape(r['figures'])})</li>"
        for r in entry["relations"]
    )
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in entry["notes"])
    return (
        f"<h2>{escape(entry['title'])}</h2><p>{escape(entry['about'])}</p>"
        f"{_table(entry['columns'], entry['rows'])}<ul>{relations}</ul>{notes}{_figures(figures)}"
    )


def _take(entry: Mapping[str, Any], figures: Sequence[tuple[str, bytes]]) -> str:
    timing = entry["timing_s"]
    spent = sum(value for stage, value in timing.items() if stage != "recorded")
    agreement = entry.get("agreement")
    lines = [f"{timing['recorded']:.1f} s recorded, baked in {spent:.2f} s."]
    if agreement:
        lines.append(
            f"Blender's evaluation and the core's agree within {agreement['position_mm']:.3f} mm and "
            f"{agreement['rotation_deg']:.4f}°."
        )
    warnings = "".join(f'<p class="warning">{escape(line)}</p>' for line in entry["warnings"])
    return (
        f"<h3>{escape(entry['take'])}</h3><p>{' '.join(lines)}</p>{warnings}{_figures(figures)}"
        f"<details><summary>Figures</summary>{_metrics_table(entry['metrics'])}</details>"
    )


def _limits(report: Mapping[str, Any]) -> str:
    if "limits" not in report:
        return ""
    if not report["failed"]:
        return f'<p class="yes">None of these: {escape("; ".join(report["limits"]))}.</p>'
    return "".join(f'<p class="no">Failed: {escape(line)}</p>' for line in report["failed"])


def _comparison(comparison: Mapping[str, Any] | None) -> str:
    if comparison is None:
        return ""
    rows = [
        [
            row["metric"],
            row["old"],
            row["new"],
            "" if row["change"] is None else f"{row['change']:+.0%}",
            row["verdict"],
        ]
        for row in comparison["rows"]
    ]
    differences = "".join(f"<li>not the same: {escape(line)}</li>" for line in comparison["differences"])
    return (
        "<h2>Against an earlier report</h2>"
        + _table(["metric", "old", "new", "change", ""], rows, [str(row[-1]) for row in rows])
        + f"<ul>{differences}</ul>"
    )
