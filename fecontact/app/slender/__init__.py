"""Ready problems of slender beams: ``fecontact ancf``."""
