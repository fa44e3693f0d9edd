"""Recordings from files of any known format, recognised by content."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numpy as np

from ..bounds import EYE_HEIGHT, RECORDING_BYTES
from ..errors import InputError
from ..presets import user_folder
from . import layouts
from .eye_height import calibrate, looking_ahead, put_down
from .formats import formats
from .happenings import in_words
from .mounts import DEVICE_MOUNTS
from .raw import RawRecording
from .recording import TRACKERS, Happening, Recording
from .repair import Repaired, repair


def read_recording(path: str | os.PathLike[str], eye_height: float | None = None) -> Recording:
    """A recording from a file, repaired and with its eye height known.

    Args:
        path: a file in one of `formats.formats()`.
        eye_height: height of the headset in metres when its wearer stands at ease; by default what the file
            states, or the recording's own standing height.

    Raises:
        InputError: a file that cannot be read, an unknown format, or a fault in it, with its place.
    """
    if eye_height is not None and not EYE_HEIGHT[0] <= eye_height <= EYE_HEIGHT[1]:
        raise InputError(f"eye height {eye_height:g} m is no person's; give metres, such as 1.65")
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
    known = formats()
    form = next((form for form in known if form.recognise(content)), None)
    if form is None:
        names = ", ".join(form.name for form in known)
        raise InputError(
            f"{path}: no known recording format; known are {names}; "
            f"for another table: {user_folder(layouts.KIND)}{layouts.layouts().note}"
        )
    raw = form.read(content, str(path))
    return to_recording(raw, str(path), hashlib.sha256(content).hexdigest(), eye_height)


def to_recording(raw: RawRecording, file: str, sha256: str, eye_height: float | None = None) -> Recording:
    """A recording of samples from anywhere, repaired and with its eye height known.

    Args:
        raw: the samples.
        file: what to call their source.
        sha256: fingerprint of the source.
        eye_height: as for `read_recording`.

    Raises:
        InputError: too few of the headset's samples are usable, or a pause is too long.
    """
    return _finish(raw, repair(raw, file), eye_height, file, sha256)


def _finish(raw: RawRecording, repaired: Repaired, given: float | None, file: str, sha256: str) -> Recording:
    """Calibrate the eye height and say what was found."""
    samples = repaired.samples
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
        "mounts": "typical of real devices" if raw.mounts is DEVICE_MOUNTS else "stated in the file",
        "tracked": ", ".join(f"{name} {share:.1%}" for name, share in zip(TRACKERS, shares, strict=True)),
    }
    if repaired.repairs:
        found["repaired"] = "; ".join(repaired.repairs)
    return Recording(
        name=raw.name or Path(file).stem,
        times=samples.times,
        positions=samples.positions + np.array([0.0, 0.0, calibration.lift]),
        rotations=samples.rotations,
        valid=samples.valid,
        mounts=raw.mounts,
        eye_height=calibration.eye_height,
        file=file,
        sha256=sha256,
        found=found,
        doubts=(*in_words(happenings, float(length)), *calibration.doubts),
        happenings=happenings,
    )
