"""Data sets in the layouts of other projects."""
