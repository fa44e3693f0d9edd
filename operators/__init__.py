"""Blender operators, one module a job."""
