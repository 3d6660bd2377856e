"""Configs: the models of YAML files, and the loader that reads them. Imports no Taichi."""

from tisph.config.loader import load
from tisph.config.schema import Config

__all__ = ["Config", "load"]
