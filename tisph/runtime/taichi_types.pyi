"""Taichi as a type checker sees it: kernels are not checked, since their annotations are Taichi's; all else is Any."""

from typing import Any
from typing import no_type_check as func
from typing import no_type_check as kernel

__all__ = ["func", "kernel"]

def __getattr__(name: str) -> Any: ...
