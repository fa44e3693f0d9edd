"""The summary of a batch as one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any
from urllib.parse import quote

from ..evaluation.page import STYLE, shown
from ..measure.catalogue import METRICS
from .progress import duration
from .summary import DONE, FAILED, KEPT

SHOWN = 500
"""Rows at most: the rest is better than these, and in the other files of the summary."""
_OWN_STYLE = """
body { max-width: 100rem; }
td.name, td.line, th.name, th.line { text-align: left; } td.line { white-space: normal; min-width: 18rem; }
tr.failed td { background: #fdecec; } tr.over td { background: #fff4d6; }
.bar { display: inline-block; height: 0.6rem; background: #d1495b; margin-left: 0.4rem; }
td.good .bar { background: #3a9d5d; }
"""
_WIDEST_REM, _WIDEST_TIMES = 6.0, 4.0


def batch_page(report: Mapping[str, Any]) -> str:
    """The page of a `summary.batch_report`, its worst recordings first."""
    rows: Sequence[Mapping[str, Any]] = report["recordings"]
    counts = report["counts"]
    states = {DONE: "baked", KEPT: "kept from an earlier run", FAILED: "failed"}
    told = ", ".join(f"{counts[state]} {words}" for state, words in states.items() if counts[state])
    over = sum(bool(row.get("failed")) for row in rows)
    rest = f" The {SHOWN} worst are here; all are in the CSV and the JSON." if len(rows) > SHOWN else ""
    parts = [
        "<h1>Footwork batch</h1>",
        f"<p>{_many(len(rows), 'recording')}: {told}; {duration(report['recorded_s'])} recorded; {_spent(report)}; "
        f"{escape(report['producer'])}.</p>",
        *(f'<p class="warning">{escape(line)}</p>' for line in report["warnings"]),
        f'<p class="no">{_many(over, "recording")} past a limit of --fail-if.</p>' if over else "",
        "<h2>The worst first</h2>",
        '<p class="note">"Times" says how many times as bad as is good the worst figure is: 1 is just good.'
        f"{rest}"
        "</p>",
        _table(rows[:SHOWN]),
    ]
    head = f'<meta charset="utf-8"><title>Footwork batch</title><style>{STYLE}{_OWN_STYLE}</style>'
    body = "\n".join(part for part in parts if part)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _spent(report: Mapping[str, Any]) -> str:
    timing = report["timing"]
    text = f"{duration(timing['wall_s'])} on {_many(timing['workers'], 'worker')}"
    if timing.get("per_minute"):
        text += f", {timing['per_minute']:.3g} per minute"
    if timing.get("peak_mb"):
        text += f", {timing['peak_mb']:.0f} MB a worker at most"
    return text


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    metrics = [name for name in _judged() if any(name in row.get("metrics", {}) for row in rows)]
    heads = [f"<th>{escape(METRICS[name].heading)}<br>{escape(METRICS[name].unit)}</th>" for name in metrics]
    head = (
        '<th class="name">recording</th><th>s</th><th>baked in s</th><th>times</th><th class="name">worst</th>'
        + "".join(heads)
        + '<th class="line">what to look at</th>'
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(_row(row, metrics) for row in rows)}</tbody></table>"


def _judged() -> list[str]:
    return [name for name, metric in METRICS.items() if metric.group != "truth" and metric.limit]


def _row(row: Mapping[str, Any], metrics: Sequence[str]) -> str:
    failed, over = row["state"] == FAILED, row.get("failed", ())
    kind = "failed" if failed else "over" if over else ""
    lines = [row["error"]] if failed else [*over, *row["warnings"]]
    name = escape(row["name"])
    name = name if failed or row.get("report") is None else f'<a href="{quote(row["report"])}">{name}</a>'
    values = row.get("metrics", {})
    cells = "".join(f"<td>{escape(shown(values.get(metric)))}</td>" for metric in metrics)
    worst = METRICS[row["worst"]].heading if row.get("worst") else ""
    return (
        f'<tr class="{kind}"><td class="name">{name}</td><td>{escape(shown(row.get("recorded_s")))}</td>'
        f"<td>{escape(shown(row.get('spent_s')))}</td>{_times(row.get('times'))}"
        f'<td class="name">{escape(worst)}</td>{cells}<td class="line">{"<br>".join(map(escape, lines))}</td></tr>'
    )


def _times(times: float | None) -> str:
    if times is None:
        return "<td></td>"
    wide = _WIDEST_REM * min(times / _WIDEST_TIMES, 1.0)
    kind = ' class="good"' if times <= 1.0 else ""
    return f'<td{kind}>{times:.1f}<span class="bar" style="width: {wide:.2f}rem"></span></td>'
