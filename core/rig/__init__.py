"""Rigs: retargeting, inverse kinematics, foot lock, head and hands."""
