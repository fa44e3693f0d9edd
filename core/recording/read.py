"""Recordings from files of any known format, recognised by content."""

from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..bounds import EYE_HEIGHT, RECORDING_BYTES
from ..errors import InputError
from ..presets import user_folder
from . import layouts
from .cut import cut
from .eye_height import calibrate, looking_ahead, put_down
from .fitting import fitted
from .formats import formats
from .happenings import in_words
from .mounts import DEVICE_MOUNTS, FITTED, SHAPES, shape_in, shape_of
from .raw import RawRecording
from .reading import columns
from .reading.answers import NO_ANSWERS, Answers
from .reading.dress import plain_table, unpacked
from .reading.folder import joined
from .reading.settle import settle
from .recording import TRACKERS, Happening, Recording
from .repair import Repaired, repair


def read_recording(path: str | os.PathLike[str], answers: Answers = NO_ANSWERS) -> Recording:
    """A recording from a file, repaired and with its eye height known.

    Args:
        path: a folder with a table for each device, or a file in one of `formats.formats()`.
        answers: what a person says of the file; what is not said the file states, or the recording itself tells.

    Raises:
        InputError: a file that cannot be read, an unknown format, or a fault in it, with its place.
    """
    answers.check()
    if Path(path).is_dir():
        content = joined(Path(path))
        raw = columns.read(content, str(path))
        return to_recording(raw, str(path), hashlib.sha256(content).hexdigest(), answers)
    content = content_of(path)
    digest = hashlib.sha256(content).hexdigest()
    content = unpacked(content, str(path))
    plain = plain_table(content)
    form = next((form for form in formats() if form.recognise(plain if form.table else content)), None)
    if form is None:
        raise InputError(
            f"{path}: no known recording format: no position and rotation of a headset is found by their names; name "
            f"them head, left and right, or describe the table in {user_folder(layouts.KIND)}{layouts.layouts().note}"
        )
    raw = form.read(plain if form.table else content, str(path))
    return to_recording(raw, str(path), digest, answers)


def is_blend(path: str | os.PathLike[str]) -> bool:
    """Whether a file is a Blender file by its content, or packed and called so."""
    try:
        with Path(path).open("rb") as stream:
            head = stream.read(7)
    except OSError:
        return False
    packed = head.startswith((b"\x28\xb5\x2f\xfd", b"\x1f\x8b")) and Path(path).suffix.lower() == ".blend"
    return head == b"BLENDER" or packed


def content_of(path: str | os.PathLike[str]) -> bytes:
    """A recording's file as it is.

    Raises:
        InputError: it cannot be read, is empty, or larger than any recording.
    """
    try:
        with Path(path).open("rb") as stream:
            # asked for so many bytes, Python would take memory for as many
            content = stream.read(
                min(os.fstat(stream.fileno()).st_size or RECORDING_BYTES, RECORDING_BYTES) + 1
            )
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check its name and rights") from error
    if len(content) > RECORDING_BYTES:
        raise InputError(f"{path}: larger than {RECORDING_BYTES // 1_000_000} MB; cut the recording")
    if not content.strip():
        raise InputError(f"{path}: the file is empty; record again")
    return content


def to_recording(
    raw: RawRecording,
    file: str,
    sha256: str,
    answers: Answers = NO_ANSWERS,
) -> Recording:
    """A recording of samples from anywhere, repaired and with its eye height known.

    Args:
        raw: the samples.
        file: what to call their source.
        sha256: fingerprint of the source.
        answers: as for `read_recording`.

    Raises:
        InputError: no reading of them shows a person, too few of the headset's samples are usable, or a pause
            is too long.
    """
    settled = _mounted(settle(raw, file, answers), answers)
    recording = repaired_recording(settled, file, sha256, answers.eye_height)
    if answers.strict and recording.doubts:
        raise InputError(f"{file}: {recording.doubts[0]}; this counts as a fault with --strict")
    return _worn(recording) if answers.auto_trim else recording


def _mounted(raw: RawRecording, answers: Answers) -> RawRecording:
    """The recording with the mounts that a person says, or the file names, and what is said of them."""
    device = shape_in(raw.found.get("device", ""))
    if answers.mounts == FITTED:
        shape, told = fitted(raw)
        how = f"fitted to the movement ({told})" if told else "typical: the movement does not tell them"
    elif answers.mounts:
        shape, how = shape_of(answers.mounts), "as you say"
    elif device and raw.mounts is DEVICE_MOUNTS:
        shape, how = SHAPES[device], "named in the file"
    else:
        return raw
    title = "" if shape.title in ("given", "fitted") else f"{shape.title}, "
    return replace(raw, mounts=shape.mounts, found={**raw.found, "mounts": f"{title}{how}: {shape.numbers}"})


def repaired_recording(
    raw: RawRecording, file: str, sha256: str, eye_height: float | None = None
) -> Recording:
    """A recording of samples in Blender's axes and metres; `eye_height` in metres, None for what they tell.

    Raises:
        InputError: too few of the headset's samples are usable, or a pause is too long.
    """
    return _finish(raw, repair(raw, file), eye_height, file, sha256)


def _worn(recording: Recording) -> Recording:
    """The recording up to where the headset is laid down for good."""
    ends = [float(item.starts[0]) for item in recording.happenings if item.kind == "laid down"]
    return cut(recording, 0.0, ends[0]) if ends and ends[0] > 0.0 else recording


def _finish(raw: RawRecording, repaired: Repaired, given: float | None, file: str, sha256: str) -> Recording:
    """Calibrate the eye height and say what was found."""
    samples = repaired.samples
    if not samples.valid[:, 0].any():
        raise InputError(
            f"{file}: the headset stays at one point while others move: it was not tracked; record it again"
        )
    level = looking_ahead(samples, raw.mounts)
    calibration = calibrate(level, given, raw.eye_height, raw.on_floor)
    if not EYE_HEIGHT[0] <= calibration.eye_height <= EYE_HEIGHT[1]:
        raise InputError(
            f"{file}: eye height {calibration.eye_height:.3g} m, {calibration.source}, is no person's; "
            "give the wearer's, check unit and floor"
        )
    happenings = repaired.happenings
    start = put_down(samples)
    if start is not None:
        low = float(samples.positions[-1, 0, 2]) + calibration.lift
        span = np.array([start]), samples.times[-1:]
        happenings += (Happening("laid down", 0, *span, height=low),)
    length, shares = samples.times[-1], samples.valid.mean(axis=0)
    found = {
        **raw.found,
        "rate": f"{(len(samples.times) - 1) / length:.1f} frames per second",
        "length": f"{length:.1f} s, {len(samples.times)} frames",
        "eye height": f"{calibration.eye_height:.2f} m, {calibration.source}",
        "mounts": raw.found.get(
            "mounts",
            f"typical of real devices: {SHAPES['vive-wands'].numbers}"
            if raw.mounts is DEVICE_MOUNTS
            else "stated in the file",
        ),
        "tracked": ", ".join(f"{name} {share:.1%}" for name, share in zip(TRACKERS, shares, strict=True)),
    }
    lift = np.array([0.0, 0.0, calibration.lift])
    if repaired.extra:
        found["other trackers"] = ", ".join(item.name for item in repaired.extra)
    if repaired.repairs:
        found["repaired"] = "; ".join(repaired.repairs)
    return Recording(
        name=raw.name or Path(file).stem,
        times=samples.times,
        positions=samples.positions + lift,
        rotations=samples.rotations,
        valid=samples.valid,
        mounts=raw.mounts,
        eye_height=calibration.eye_height,
        file=file,
        sha256=sha256,
        found=found,
        doubts=(*raw.doubts, *in_words(happenings, float(length)), *calibration.doubts),
        happenings=happenings,
        extra=tuple(replace(item, positions=item.positions + lift) for item in repaired.extra),
    )
