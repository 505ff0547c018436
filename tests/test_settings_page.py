"""The page of settings says what the settings are."""

from __future__ import annotations

import runpy
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"


def test_the_page_of_settings_is_what_the_types_say() -> None:
    page = runpy.run_path(str(DOCS / "settings_page.py"))["page"]()
    message = "out of date: run .venv/bin/python docs/settings_page.py"
    assert (DOCS / "settings.md").read_text("utf-8") == page, message
