"""Layouts of 6D pose estimators."""
