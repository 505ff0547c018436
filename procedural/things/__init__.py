"""Everyday things at their real sizes, drawn without files: each part closed, with a material of its own."""
