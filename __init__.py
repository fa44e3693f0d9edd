"""Footwork: full-body avatar animation from a VR headset and two hand controllers, inside Blender."""

_commands: list[object] = []


def register() -> None:
    """Add Footwork to Blender."""
    import bpy

    from . import operators, panels, properties

    properties.register()
    operators.register()
    panels.register()
    _commands.append(bpy.utils.register_cli_command("footwork", _command))


def unregister() -> None:
    """Take Footwork out of Blender again, leaving nothing behind."""
    import bpy

    from . import operators, panels, properties

    bpy.utils.unregister_cli_command(_commands.pop())
    panels.unregister()
    operators.unregister()
    properties.unregister()


def _command(arguments: list[str]) -> int:
    """`blender --command footwork VERB ...`."""
    from .cli import main

    return main(arguments)
