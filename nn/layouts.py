"""The windows of the networks that Footwork trains."""

from __future__ import annotations

import numpy as np

from .windows import Layout

LOOK_AHEAD = Layout(np.round(np.arange(-10, 11) * 0.1, 3), 2)
"""One second to both sides in steps of 0.1 s, rotations every 0.2 s."""
CAUSAL = Layout(np.round(np.arange(-20, 1) * 0.1, 3), 2)
"""The last two seconds in steps of 0.1 s, rotations every 0.2 s."""
