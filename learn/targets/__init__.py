"""Training targets of a view: depth, classes, heatmap, offsets, and the fields of boxes."""
