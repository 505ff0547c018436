"""Proofs of stored labels, by code that shares nothing with what made them but the types of files."""
