"""Motion databases: virtual root, contacts, poses, features, the side-car file."""
