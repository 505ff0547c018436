"""A data set to look at: one page for a browser, or a recording for Rerun."""
