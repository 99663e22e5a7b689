"""Two spheres pressed together: the main job."""
