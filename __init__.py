"""Footwork: full-body avatar animation from a VR headset and two hand controllers, inside Blender."""


def register() -> None:
    """Add Footwork to Blender."""
    from . import operators, panels

    operators.register()
    panels.register()


def unregister() -> None:
    """Take Footwork out of Blender again, leaving nothing behind."""
    from . import operators, panels

    panels.unregister()
    operators.unregister()
