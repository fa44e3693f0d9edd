"""What files from outside may ask for, and what a body can be: budgets and physical bounds, each once.

Budgets are compared before memory is set aside. They bound what a file makes of itself by its own size, so that small
files stay cheap, and leave long recordings and large databases alone. Bounds are wide: they refuse what cannot be, and
leave what is unlikely to the doubts of the readers.
"""

from __future__ import annotations

Span = tuple[float, float]
"""Least and greatest value, both allowed."""

# What bodies, recordings and takes can be
EYE_HEIGHT: Span = (0.3, 3.0)
"""Metres: children and people on stilts are between. By option, in a file, or measured."""
FARTHEST = 1e4
"""Metres: nothing is farther away; larger numbers are none of a pose."""
BODY_LENGTH: Span = (0.2, 5.0)
"""Metres along thigh and shin and from the hips to the head."""
BONE_SHARE = 0.7
"""Of that length: no single bone is longer."""
HEAD_HEIGHT: Span = (0.2, 4.0)
"""Metres from the floor to the head joint of who stands at ease."""
LONGEST_BONE = 3.0
"""Metres."""
FASTEST = 1e4
"""Metres per second: takes jump, but not farther."""
HEIGHT_SHARE: Span = (-10.0, 10.0)
"""Headset heights over standing eye height."""
MOST_TURNS = 1e5
"""Radians of a yaw that runs on."""
FEATURE = 1e5
"""Normalised, its mean and its deviation."""
WEIGHT = 1e4
"""Of a network, trained or at the start."""
INPUT_DEVIATION: Span = (1e-9, 1e6)
INPUT_MEAN = 1e6
FRAME_TIME: Span = (1e-6, 10.0)
"""Seconds between two frames of a take."""
TAKE_RATE: Span = (1.0, 5000.0)
"""Frames per second of a take, where a person or a file states them."""
RECORDING_RATE: Span = (2.0, 5000.0)
"""Samples per second."""
BVH_NUMBER = 1e9
"""No length, angle or count of a take is larger, in whatever unit."""

LARGEST_FIGURE = 1e12
"""No figure of a report is larger, whatever its unit."""

# Budgets of arrays in .npz files
NPZ_BYTES = 1 << 34
NPZ_DIRECTORY_BYTES = 1 << 21
NPZ_DIRECTORY_ENTRIES = 20_000
EXPANDED_BYTES, EXPANDED_TIMES = 64 << 20, 50
"""All arrays that are read have together at most so many bytes, or so many times the bytes of their file."""
# JSON
JSON_BYTES = 16_000_000
"""Descriptions inside of other files."""
PRESET_BYTES = 1_000_000
TAKE_BYTES = 4_000_000_000
"""Of a take that is read whole."""
RECORDING_BYTES = 1_000_000_000
REPORT_BYTES = 256_000_000
TABLE_BYTES = 1_000_000_000
"""The jobs of a batch: millions of rows."""
JSON_DEPTH = 64
JSON_DIGITS = 300
"""Longer numbers are none of a measurement."""

TEXTS = 10_000
"""Tags of a database, and the like."""
JOINTS, DEPTH = 4096, 256
"""Joints of a hierarchy, and how many may hang on one another."""
JOINT_FRAMES = 250_000
"""Joints times frames of a take with fewer channels than joints; with more, its numbers bound them."""
RESAMPLED_JOINT_FRAMES, RESAMPLED_TIMES = 1_000_000, 24
"""Another rate may make joints times frames so many, or so many times as many."""
PAUSE_S = 600.0
"""The longest pause of a recording."""
PAUSE_SAMPLES, PAUSE_TIMES = 100_000, 2
"""All its pauses are bridged with so many samples at most, or so many times as many as were recorded."""
CLIPS = 1_000_000
FRAMES = 50_000_000
NETWORKS, LAYERS, WIDTH = 64, 16, 65_536
"""Of a predictor: networks that vote, layers of each, numbers of a layer."""
