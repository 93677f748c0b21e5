"""Embree, which `librelievo` opens when a ray is cast."""

from pathlib import Path

FILE = Path(__file__).resolve().parent / "libembree3-relievo.so"
