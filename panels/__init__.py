"""Properties, panels and lists of the user interface."""
