"""Evaluation metrics on NumPy arrays: depth errors, box IoU, average precision, mask AP, pose errors."""
