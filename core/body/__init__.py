"""What a body is and does: skeletons and motions, their poses, standing, limbs, legs and feet."""
