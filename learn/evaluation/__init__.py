"""What a frozen network is worth on a data set."""
