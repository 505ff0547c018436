"""The on-disk format of a data set, one file type per module."""
