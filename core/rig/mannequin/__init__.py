"""A mannequin: a body of average build around any skeleton, and how the skeleton's joints carry it."""
