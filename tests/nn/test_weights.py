"""Predictor files: exact round trips, and one clear line for each way a file can be wrong."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.recording.windows import WindowLayout
from footwork.nn.inputs import Scaler
from footwork.nn.network import Network
from footwork.nn.weights import Predictor, read_predictor, save_predictor

LAYOUT = WindowLayout(np.array([-0.2, -0.1, 0.0, 0.1, 0.2]), 2)


def _network(rng: np.random.Generator, *sizes: int) -> Network:
    pairs = list(itertools.pairwise(sizes))
    return Network(
        tuple(rng.normal(size=pair).astype(np.float32) for pair in pairs),
        tuple(rng.normal(size=pair[1]).astype(np.float32) for pair in pairs),
    )


def _predictor(layout: WindowLayout | None) -> Predictor:
    rng = np.random.default_rng(1)
    inputs, outputs = (42, 6) if layout is None else (layout.inputs, 2)
    networks = tuple(_network(rng, inputs, 8, 8, outputs) for _ in range(1 if layout is None else 2))
    scaler = Scaler(rng.normal(size=inputs), rng.uniform(0.5, 2.0, inputs))
    return Predictor("p", networks, scaler, layout, 0.1, {"takes": [{"take": "a", "licence": "MIT"}]})


@pytest.mark.parametrize("layout", [None, LAYOUT])
def test_round_trip(tmp_path, layout):
    predictor = _predictor(layout)
    save_predictor(tmp_path / "p.npz", predictor)
    found = read_predictor(tmp_path / "p.npz")
    assert (found.name, found.kind, found.causal) == ("p", predictor.kind, layout is None)
    assert found.provenance == predictor.provenance
    assert found.smoothing == 0.1
    np.testing.assert_array_equal(found.scaler.mean, predictor.scaler.mean)
    for a, b in zip(found.networks, predictor.networks, strict=True):
        for x, y in zip((*a.weights, *a.biases), (*b.weights, *b.biases), strict=True):
            np.testing.assert_array_equal(x, y)


def test_same_predictor_same_bytes(tmp_path):
    save_predictor(tmp_path / "a.npz", _predictor(LAYOUT))
    save_predictor(tmp_path / "b.npz", _predictor(LAYOUT))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def _fails(path, *words: str) -> None:
    with pytest.raises(InputError) as caught:
        read_predictor(path)
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    for word in words:
        assert word in message


def test_files_that_are_no_predictor(tmp_path):
    _fails(tmp_path / "missing.npz", "cannot be read")
    _fails(tmp_path, "cannot be read")
    for content in (b"", b"PK\x03\x04 half a zip", b"\x93NUMPY nonsense", b"hello" * 100):
        (tmp_path / "x.npz").write_bytes(content)
        _fails(tmp_path / "x.npz", "no ")
    np.savez(tmp_path / "y.npz", a=np.zeros(3))
    _fails(tmp_path / "y.npz", "no Footwork predictor")
    np.save(tmp_path / "z.npy", np.zeros(3))
    _fails(tmp_path / "z.npy", "no ")


def test_a_truncated_file(tmp_path):
    path = tmp_path / "p.npz"
    save_predictor(path, _predictor(LAYOUT))
    whole = path.read_bytes()
    for share in (0.1, 0.5, 0.9, 0.99):
        path.write_bytes(whole[: int(share * len(whole))])
        _fails(path)


def _altered(path, header: dict | None = None, **arrays):
    """The file at `path` with other header fields or arrays; None takes an array away."""
    with np.load(path) as found:
        content = {key: found[key] for key in found.files}
    if header is not None:
        old = json.loads(content["header"].tobytes())
        old.update(header)
        content["header"] = np.frombuffer(json.dumps(old).encode(), dtype=np.uint8)
    content.update(arrays)
    np.savez(path, **{key: value for key, value in content.items() if value is not None})


@pytest.mark.parametrize(
    ("header", "arrays", "word"),
    [
        ({"schema": 99}, {}, "update Footwork"),
        ({"schema": "one"}, {}, "schema"),
        ({"format": "footwork-database"}, {}, "no Footwork predictor"),
        ({"kind": "magic"}, {}, "description"),
        ({"sizes": [[42, -1, 6]]}, {}, "description"),
        ({"sizes": []}, {}, "description"),
        ({"sizes": [[3, 8, 8, 2]]}, {}, "maps 3"),
        ({"smoothing": -1.0}, {}, "description"),
        ({"rotations_every": 10**200}, {}, "description"),
        ({"provenance": {"held_out_error_deg": "small"}}, {}, "description"),
        ({"provenance": {"held_out_error_deg": 1e30}}, {}, "description"),
        ({"provenance": {"settings": [1]}}, {}, "description"),
        ({}, {"bias_0_0": np.full(8, 1e30, np.float32)}, "weight is larger"),
        ({}, {"mean": np.full(LAYOUT.inputs, 1e30)}, "scaler"),
        ({}, {"deviation": np.full(LAYOUT.inputs, 1e-300)}, "scaler"),
        ({"rotations_every": 0}, {}, "description"),
        ({}, {"mean": None}, "mean"),
        ({}, {"deviation": np.zeros(LAYOUT.inputs)}, "deviation"),
        ({}, {"weight_0_1": np.zeros((3, 3), np.float32)}, "weight_0_1"),
        ({}, {"bias_1_0": np.full(8, np.nan, np.float32)}, "finite"),
        ({}, {"offsets": np.array([0.3, 0.1, 0.0])}, "window"),
        ({}, {"offsets": None}, "window"),
        ({}, {"weight_0_0": np.array([["a"]])}, "weight_0_0"),
    ],
)
def test_damage_inside(tmp_path, header, arrays, word):
    path = tmp_path / "p.npz"
    save_predictor(path, _predictor(LAYOUT))
    _altered(path, header, **arrays)
    _fails(path, word)


def test_pickled_content_is_never_loaded(tmp_path):
    path = tmp_path / "p.npz"
    save_predictor(path, _predictor(LAYOUT))
    _altered(path, mean=np.array([{"a": 1}], dtype=object))
    _fails(path)
