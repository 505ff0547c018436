"""Scenes put together by hand: bodies of a few numbers, a board, a camera."""
