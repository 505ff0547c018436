"""Layouts of object detectors: instances, keypoints."""
