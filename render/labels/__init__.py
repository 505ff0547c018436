"""Noise-free label images: straight and refracted rays through exact pixel centres."""
