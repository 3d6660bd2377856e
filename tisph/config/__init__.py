"""Configs: what a YAML file may say, and the loader that reads it. Imports no Taichi."""

from tisph.config.loader import load
from tisph.config.schema import Config

__all__ = ["Config", "load"]
