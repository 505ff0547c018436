"""Decoding: from the outputs of a network to objects, with peaks, boxes, poses and masks."""
