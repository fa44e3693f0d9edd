"""Quaternions, angles, vectors, filters and time derivatives over arrays."""
