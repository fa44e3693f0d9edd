"""Takes as users: bakes compared with the truth, the paper's experiments, limits, the report page."""
