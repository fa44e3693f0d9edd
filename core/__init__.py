"""The whole method in numpy: callable from any Python, without Blender or torch."""

VERSION = "0.1.0"
"""As in the extension's manifest; written into every file that Footwork makes."""
