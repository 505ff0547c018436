"""Builds of many scenes: planned, made by worker processes or a cluster, logged, checked and merged."""
