"""Takes: BVH in and out, skeletons, joint roles, T-poses."""
