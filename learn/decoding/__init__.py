"""From a network's outputs to objects: peaks, boxes, poses and masks."""
