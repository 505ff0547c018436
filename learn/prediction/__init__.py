"""Prediction in pictures of your own: their cameras and lenses, checks, windows, drawn output."""
