"""The user's folder of presets: where it is, what counts, what is skipped, and that changes are noticed."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from footwork.core import presets
from footwork.core.body.skeleton import REQUIRED_ROLES
from footwork.core.bounds import PRESET_BYTES
from footwork.core.errors import InputError
from footwork.core.mocap import families
from hypothesis import given, settings
from hypothesis import strategies as st

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)


@dataclass(frozen=True)
class Toy:
    """A preset of a kind that only this test knows."""

    name: str
    colours: tuple[str, ...]


def parse(content: Any) -> Toy:
    data = presets.check_keys(content, ("name",), ("colours",))
    return Toy(
        presets.check_text(data["name"], "'name'"),
        presets.check_texts(data.get("colours", []), "'colours'"),
    )


def read(path: str | os.PathLike[str]) -> Toy:
    return presets.read_preset(path, parse, "toy")


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, Any], Path]:
    """Writes a file into the user's folder of toys; two toys ship."""
    monkeypatch.setenv(presets.VARIABLE, str(tmp_path / "own"))
    monkeypatch.setattr(presets, "SHIPPED", tmp_path / "shipped")
    presets._load.cache_clear()
    for name in ("ball", "kite"):
        path = tmp_path / "shipped" / "toys" / f"{name}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"name": name, "colours": ["red"]}))
    (tmp_path / "own").mkdir()

    def write(file: str, content: Any) -> Path:
        path = tmp_path / "own" / "toys" / file
        path.parent.mkdir(exist_ok=True)
        path.write_text(content if isinstance(content, str) else json.dumps(content), "utf-8")
        return path

    return write


def names() -> list[str]:
    return [toy.name for toy in presets.load_presets("toys", read).entries]


@pytest.mark.parametrize(
    ("platform", "environment", "expected"),
    [
        ("linux", {}, "/home/ada/.config/footwork"),
        ("linux", {"XDG_CONFIG_HOME": "/etc/ada"}, "/etc/ada/footwork"),
        ("linux", {"XDG_CONFIG_HOME": "not/absolute"}, "/home/ada/.config/footwork"),
        ("darwin", {"XDG_CONFIG_HOME": "/etc/ada"}, "/home/ada/Library/Application Support/Footwork"),
        ("win32", {"APPDATA": "/c/ada/Roaming"}, "/c/ada/Roaming/Footwork"),
        ("win32", {}, "/home/ada/AppData/Roaming/Footwork"),
    ],
)
def test_each_platform_has_a_place_for_settings(
    platform: str, environment: dict[str, str], expected: str
) -> None:
    assert presets.configuration_folder(platform, environment, Path("/home/ada")) == Path(expected)


@pytest.mark.skipif(os.name == "nt", reason="HOME is not asked there")
def test_without_the_variable_the_users_own_settings_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(presets.VARIABLE)
    monkeypatch.delenv("XDG_CONFIG_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert tmp_path in presets.user_folder("toys").parents
    assert presets.load_presets("toys", read).skipped == ()
    assert list(tmp_path.iterdir()) == [], "reading creates nothing"


def test_the_users_presets_come_first_and_replace_those_that_ship(own) -> None:
    assert names() == ["ball", "kite"]
    own("z.json", {"name": "top"})
    own("my_ball.JSON", {"name": "ball", "colours": ["blue"]})
    found = presets.load_presets("toys", read)
    assert [(toy.name, toy.colours) for toy in found.entries] == [
        ("ball", ("blue",)),
        ("top", ()),
        ("kite", ("red",)),
    ]
    assert found.skipped == ()


def test_files_that_are_added_changed_and_removed_are_noticed(own) -> None:
    path = own("a.json", {"name": "top"})
    first = presets.load_presets("toys", read)
    assert presets.load_presets("toys", read) is first, "nothing changed, so nothing is read"
    stat = path.stat()
    path.write_text(json.dumps({"name": "tip"}))
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns + 1_000_000))
    assert names() == ["tip", "ball", "kite"]
    second = own("b.json", {"name": "drum"})
    assert names() == ["tip", "drum", "ball", "kite"]
    second.unlink()
    path.unlink()
    assert names() == ["ball", "kite"]


BROKEN = {
    "": "line 1",
    "{": "line 1",
    '{"name": "x",\n\n,}': "line 3",
    "[1]": "not an object",
    "null": "not an object",
    "7": "not an object",
    "{}": "no 'name'",
    '{"name": ""}': "one line",
    '{"name": "a\\nb"}': "one line",
    '{"name": "\\ud800"}': "half of a letter",
    '{"name": "\\u001b[2J"}': "one line",
    '{"name": 3}': "one line",
    '{"name": NaN}': "NaN",
    '{"name": "x", "colours": -Infinity}': "-Infinity",
    '{"name": "x", "colours": "red"}': "not a list",
    '{"name": "x", "colours": {"red": 1}}': "not a list",
    '{"name": "x", "colours": ["red", null]}': "item of 'colours'",
    '{"name": "x", "colour": []}': "'colour', which is none of name, colours",
    '{"name": "x", "name": "y"}': "'name' stands twice",
    '{"name": ' + "[" * 100_000: "nested too deeply",
    '{"name": ' + "9" * 10_000 + "}": "broken JSON",
    '{"name": "x"}' + " " * PRESET_BYTES: "larger than 1 MB",
    '{"name": "kite"} and more': "line 1",
}


@pytest.mark.parametrize("text", BROKEN, ids=range(len(BROKEN)))
def test_a_broken_file_is_named_with_its_fault_and_the_others_stay(own, text: str) -> None:
    own("good.json", {"name": "top"})
    path = own("broken.json", text)
    found = presets.load_presets("toys", read)
    assert [toy.name for toy in found.entries] == ["top", "ball", "kite"]
    (line,) = found.skipped
    assert str(path) in line and BROKEN[text] in line
    assert line.isprintable() and len(line) < 600


@settings(max_examples=200, deadline=None)
@given(content=JSON)
def test_whatever_a_file_holds_it_is_a_preset_or_a_fault(
    tmp_path_factory: pytest.TempPathFactory, content: Any
) -> None:
    path = tmp_path_factory.mktemp("toys") / "any.json"
    path.write_text(json.dumps(content))
    try:
        assert read(path).name == content["name"]
    except InputError as error:
        assert str(path) in str(error)


@pytest.mark.parametrize("content", [b"\xff\xfe{\x00}\x00", b"\x00\x01\x02", b'{"name": "\xe9"}'])
def test_files_that_are_no_text(own, content: bytes) -> None:
    own("broken.json", "").write_bytes(content)
    assert len(presets.load_presets("toys", read).skipped) == 1
    assert names() == ["ball", "kite"]


def test_a_mark_at_the_start_of_the_file_is_no_fault(own) -> None:
    own("notepad.json", '\ufeff{"name": "top"}')
    assert names() == ["top", "ball", "kite"]


def test_two_files_of_one_name(own) -> None:
    own("a.json", {"name": "top", "colours": ["blue"]})
    own("b.json", {"name": "top"})
    found = presets.load_presets("toys", read)
    assert found.entries[0].colours == ("blue",)
    assert len(found.skipped) == 1
    assert "b.json" in found.skipped[0] and "a.json has the same name 'top'" in found.skipped[0]


def test_things_that_are_no_files(own) -> None:
    folder = own("good.json", {"name": "top"}).parent
    (folder / "folder.json").mkdir()
    (folder / "nowhere.json").symlink_to(folder / "absent")
    (folder / "._good.json").write_text("what some systems leave beside a file")
    (folder / "notes.txt").write_text("not a preset")
    if hasattr(os, "mkfifo"):
        os.mkfifo(folder / "pipe.json")
    found = presets.load_presets("toys", read)
    assert [toy.name for toy in found.entries] == ["top", "ball", "kite"]
    skipped = [Path(line.split(": ")[0]).name for line in found.skipped]
    assert skipped == ["folder.json", "nowhere.json", *["pipe.json"] * hasattr(os, "mkfifo")]


@pytest.mark.skipif(os.name == "nt", reason="such names cannot exist there")
def test_names_that_cannot_be_shown_are_made_showable(own) -> None:
    folder = own("good.json", {"name": "top"}).parent
    Path(os.fsdecode(os.fsencode(folder) + b"/bad\n\xff.json")).write_text("[]")
    (line,) = presets.load_presets("toys", read).skipped
    assert line.isprintable()
    line.encode()


def test_a_variable_that_leads_nowhere_is_told(own, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(presets.VARIABLE, str(tmp_path / "absent"))
    found = presets.load_presets("toys", read)
    assert [toy.name for toy in found.entries] == ["ball", "kite"]
    assert len(found.skipped) == 1
    assert presets.VARIABLE in found.skipped[0] and "there is no folder" in found.skipped[0]
    assert not (tmp_path / "absent").exists()
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(presets.VARIABLE, str(tmp_path / "file"))
    assert "cannot be listed" in presets.load_presets("toys", read).skipped[0]


def test_files_that_are_given_count_before_all_others_for_a_time(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv(presets.VARIABLE, str(tmp_path / "own"))
    shipped = json.loads((presets.SHIPPED / families.KIND / "xsens.json").read_text("utf-8"))
    path = tmp_path / "given.json"
    path.write_text(json.dumps({**shipped, "name": "Given"}))
    with presets.given_presets(families.KIND, [str(path)]):
        assert families.families().entries[0].name == "Given"
    assert all(entry.name != "Given" for entry in families.families().entries)


def test_a_preset_that_is_kept_is_found_again(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv(presets.VARIABLE, str(tmp_path))
    roles = {role: f"bone {3 * number}" for number, role in enumerate((*REQUIRED_ROLES, "spine1", "chest"))}
    path = presets.keep_preset(families.KIND, "my/rig", families.family_of("my/rig", roles))
    assert path.parent == tmp_path / families.KIND
    found = families.families().entries[0]
    assert found.name == "my/rig" and found.names["hand.R"] == (roles["hand.R"].replace(" ", ""),)
    presets.keep_preset(families.KIND, "my/rig", families.family_of("my/rig", roles | {"head": "top"}))
    assert families.families().entries[0].names["head"] == ("top",) and not families.families().skipped


@pytest.mark.parametrize(
    ("change", "words"),
    [({"head": ""}, "no head"), ({"head": "bone_0"}, "same name"), ({"hips": "--"}, "without letters")],
)
def test_a_map_that_would_say_nothing_is_not_kept(change: dict[str, str], words: str) -> None:
    roles = {role: f"bone {3 * number}" for number, role in enumerate(REQUIRED_ROLES)}
    with pytest.raises(InputError, match=words):
        families.family_of("mine", roles | change)
