"""Shards for streaming, with the cards that describe a data set."""
