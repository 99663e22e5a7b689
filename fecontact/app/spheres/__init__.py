"""Two spheres pressed together, compared with Hertz."""
