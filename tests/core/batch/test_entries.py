"""Which recordings a batch has, and how long it takes."""

from __future__ import annotations

from pathlib import Path

import pytest
from footwork.core.batch.entries import find_entries, in_folder, largest_first
from footwork.core.batch.page import batch_page
from footwork.core.batch.progress import Progress, duration
from footwork.core.batch.summary import batch_report, failed_row, to_csv, worst_of
from footwork.core.errors import InputError


def make(folder: Path, *names: str) -> None:
    for size, name in enumerate(names, 1):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(b"x" * size)


def test_a_folder_and_a_pattern_name_recordings_by_their_place(tmp_path: Path) -> None:
    make(
        tmp_path,
        "a.csv",
        "day1/b.bsor",
        "day1/b.csv",
        "day2/c.json",
        ".hidden.csv",
        "note.pdf",
        "summary.csv",
    )
    names = {entry.name for entry in find_entries(str(tmp_path))}
    assert names == {"a", "day1/b.bsor", "day1/b.csv", "day2/c", "summary.csv"}
    found = find_entries(str(tmp_path / "day*" / "*.bsor"))
    assert [(entry.name, Path(entry.recording)) for entry in found] == [
        ("day1/b", tmp_path / "day1" / "b.bsor")
    ]
    sizes = [size for _, size in largest_first(find_entries(str(tmp_path)))]
    assert sizes == sorted(sizes, reverse=True)
    with pytest.raises(InputError, match="no recordings found"):
        find_entries(str(tmp_path / "*.tsv"))
    assert in_folder(found, tmp_path) is found[0] and in_folder(found, tmp_path / "out") is None


TABLES = {
    "t.csv": "recording, output, alpha, database\nr/a.csv, one/a, 0.2,\nb.csv,,,x.npz;y.npz\n",
    "t.json": '[{"recording": "r/a.csv", "output": "one/a", "alpha": "0.2"},'
    '{"recording": "b.csv", "database": "x.npz;y.npz"}]',
    "t.toml": '[[job]]\nrecording = "r/a.csv"\noutput = "one/a"\nsettings = {alpha = "0.2"}\n'
    '[[job]]\nrecording = "b.csv"\ndatabase = "x.npz;y.npz"\n',
}


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_all_kinds_say_the_same(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(TABLES[name])
    a, b = find_entries(str(tmp_path / name))
    assert (a.name, Path(a.recording), dict(a.values)) == (
        "one/a",
        tmp_path / "r" / "a.csv",
        {"alpha": "0.2"},
    )
    assert (b.name, dict(b.values), b.folder) == ("b", {"database": "x.npz;y.npz"}, tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("t.csv", "file\na.csv\n", "no column 'recording'"),
        ("t.csv", "recording\na.csv,1\n", "line 2: more cells"),
        ("t.csv", "recording,output\na.csv,x\nb.csv,X\n", "line 3: 'X' is taken by"),
        ("t.csv", "recording,output\na.csv,../x\n", "no name for outputs"),
        ("t.csv", "recording,output\na.csv,summary\n", "the batch's own files"),
        ("t.csv", "recording\n", "names no recording"),
        ("t.json", "{", "broken JSON"),
        ("t.json", "[3]", "row 1 has no names"),
        ("t.json", '[{"output": "a"}]', "row 1: no recording"),
        ("t.toml", "job = 3", "no list of rows"),
        ("t.toml", "x = ", "broken TOML"),
        ("t.txt", "a", "no folder, pattern or table"),
    ],
)
def test_bad_tables_are_refused_in_a_line(tmp_path: Path, name: str, content: str, said: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=said):
        find_entries(str(tmp_path / name))


def test_the_time_left_follows_from_bytes_and_workers() -> None:
    progress = Progress(total=12, waiting_bytes=1200, workers=2)
    for _ in range(2):
        progress = progress.after(100, 5.0, baked=True)
    assert progress.seconds_left() is None and "not known" in progress.in_words(5.0)
    progress = progress.after(100, 1e6, baked=False)  # kept ones say nothing
    progress = progress.after(100, 5.0, baked=True)
    # 800 bytes wait at 0.05 s each, on two workers
    assert progress.seconds_left() == pytest.approx(20.0)
    assert progress.in_words(7.5) == "[ 4/12] 24 per minute, about 20 s left"
    assert [duration(s) for s in (7.0, 600.0, 7200.0, 864_000.0)] == ["7 s", "10 min", "2.0 h", "10.0 days"]


def test_the_summary_has_the_worst_first_and_shows_names_as_text() -> None:
    rows = [
        {
            "name": name,
            "recording": f"{name}.csv",
            "state": "done",
            "times": times,
            "worst": "",
            "failed": over,
        }
        | {"warnings": [], "metrics": {}, "producer": "p", "recorded_s": 20.0}
        for name, times, over in (("a", 0.5, []), ("b", 3.0, []), ("c", 0.1, ["x > 1: it is 2"]))
    ]
    rows.append(failed_row("d.csv", "<d>", ["d.csv: broken"]))
    report = batch_report(rows, {"wall_s": 10.0, "workers": 2})
    assert [row["name"] for row in report["recordings"]] == ["<d>", "c", "b", "a"]
    assert report["unfinished"] == ["<d>"] and report["failed"] == ["c: x > 1: it is 2"]
    page = batch_page(report)
    assert "<d>" not in page and page.index("&lt;d&gt;") < page.index(">c<") < page.index(">a<")
    assert [line.split(",")[0] for line in to_csv(report).splitlines()] == ["name", "<d>", "c", "b", "a"]
    assert worst_of({"root_error_cm": 30.0, "hand_position_error_cm": 1.5}) == ("root_error_cm", 2.0)
