"""Motion that ships as a small network: a root path and a plan of steps go in, a body's takes come out."""
