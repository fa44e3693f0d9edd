"""Quaternions, angles, kinematics and filters over arrays."""
