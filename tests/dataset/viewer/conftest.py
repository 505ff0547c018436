from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
import zlib
from base64 import b64decode, b64encode
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@dataclass(frozen=True)
class Page:
    """A page, with the records that its script reads."""

    path: Path
    text: str

    def record(self, name: str) -> dict[str, Any]:
        found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', self.text, re.DOTALL)
        assert found, name
        return json.loads(found[1])

    def maps(self, view: str = "view-0-0") -> dict[str, Any]:
        return {one["name"]: one for one in self.record(view)["maps"]}

    def script_hash(self) -> str:
        """Return the hash of the only script that a browser may run, as a policy states it."""
        (script,) = re.findall(r"<script>(.*?)</script>", self.text, re.DOTALL)
        return "sha256-" + b64encode(hashlib.sha256(script.encode()).digest()).decode()


def unpacked(one: dict[str, Any]) -> np.ndarray:
    """Undo `packed` by sums along rows, number by number."""
    kind = np.dtype(one["type"])
    planes = np.frombuffer(zlib.decompress(b64decode(one["data"])), np.uint8).reshape(kind.itemsize, -1)
    words = planes.T.copy().view(f"u{kind.itemsize}").reshape(one["shape"])
    return np.cumsum(words, axis=1, dtype=words.dtype).view(kind)


@pytest.fixture
def page() -> Callable[[Path], Page]:
    return lambda path: Page(path, path.read_text("utf-8"))


@pytest.fixture
def unpack() -> Callable[[dict[str, Any]], np.ndarray]:
    return unpacked


@pytest.fixture
def browser(tmp_path) -> Callable[..., str]:
    """(page, address behind #, options) -> what chromium prints; it has no network."""
    if CHROMIUM is None:
        pytest.skip("needs chromium")

    def show(path: Path, address: str, *options: str) -> str:
        command = [str(CHROMIUM), "--headless", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader"]
        command += ["--enable-unsafe-swiftshader", f"--user-data-dir={tmp_path / 'profile'}"]
        command += ["--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=20000", "--window-size=1280,900"]
        run = subprocess.run(
            [*command, *options, f"{path.as_uri()}#{address}"], capture_output=True, timeout=180, check=True, text=True
        )
        return run.stdout

    return show
