"""Takes: BVH in and out, joint roles by name, T-poses, floor, checks, procedural takes."""
