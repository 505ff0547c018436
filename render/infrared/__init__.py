"""Infrared light of depth cameras: pictures of a projector's dots and ambient light, beams of time of flight."""
