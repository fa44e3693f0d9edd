"""The windows of the networks that Footwork trains."""

from __future__ import annotations

import numpy as np

from .windows import Layout

LOOK_AHEAD = Layout(np.round(np.arange(-10, 11) * 0.1, 3), 2)
"""One second to both sides in steps of 0.1 s, rotations every 0.2 s."""
CAUSAL = Layout(
    -np.array(
        [3.0, 2.5, 2.1, 1.8, 1.5, 1.25, 1.05, 0.9, 0.75, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.05, 0.0]
    ),
    2,
)
"""The last three seconds, denser towards the moment itself."""
