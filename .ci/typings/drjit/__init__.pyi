"""Unknown to the type checker: the real stubs describe arrays that no variant has."""

from typing import Any

def __getattr__(name: str) -> Any: ...
