"""The version number of settings that are kept in files."""

from bpy.props import IntProperty


class Versioned:
    """Settings that know which Footwork wrote them."""

    version: IntProperty(
        name="Version",
        description="How many steps of the upgrade these settings have behind them",
        min=0,
        options={"HIDDEN"},
    )
