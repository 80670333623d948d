"""What all tests share: compiled kernels are kept under build/, and hypothesis tries the same examples every time."""

from __future__ import annotations

import os
from pathlib import Path

from hypothesis import settings

os.environ.setdefault("MICROFACET_CACHE", str(Path(__file__).parent.parent / "build" / "kernels"))

settings.register_profile("repeatable", deadline=None, derandomize=True, database=None, max_examples=60)
settings.load_profile("repeatable")
