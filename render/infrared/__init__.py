"""Infrared pictures of an active stereo camera: the projector's dots, and ambient light."""
