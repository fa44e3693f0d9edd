"""What files from outside may ask for, and what a body can be: budgets and physical bounds, each once.

Budgets are compared before memory is set aside. They bound what a file makes of itself by its own size, so that small
files stay cheap, and leave long recordings and large databases alone. Bounds are wide: they refuse what cannot be, and
leave what is unlikely to the doubts of the readers.
"""

from __future__ import annotations

Span = tuple[float, float]
"""Least and greatest value, both allowed."""

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
RECORDING_BYTES = 1_000_000_000
REPORT_BYTES = 256_000_000
JSON_DEPTH = 64
JSON_DIGITS = 300
"""Longer numbers are none of a measurement."""

TEXTS = 10_000
"""Tags of a database, and the like."""
JOINTS = 4096
"""Of a hierarchy."""
CLIPS = 1_000_000
FRAMES = 50_000_000
NETWORKS, LAYERS, WIDTH = 64, 16, 65_536
"""Of a predictor: networks that vote, layers of each, numbers of a layer."""
