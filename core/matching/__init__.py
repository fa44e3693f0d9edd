"""Motion matching: trajectory, search, playback, inertialization."""
