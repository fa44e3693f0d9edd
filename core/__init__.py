"""The whole method in numpy: callable from any Python, without Blender or torch."""
