"""One line on stderr that says how far something is."""

from __future__ import annotations

import sys
from types import TracebackType


class Progress:
    """Shows a time on its way to an end, while ``shown``; a context that ends the line."""

    def __init__(self, shown: bool, start: float = 0.0) -> None:
        self._shown = shown
        self._start = start
        self._begun = False

    def __call__(self, time: float, end: float) -> None:
        """Shows the time ``time`` on the way to ``end``."""
        if not self._shown:
            return
        share = (time - self._start) / (end - self._start or 1.0)
        sys.stderr.write(f"\rt = {time:.4g} of {end:.4g} ({share:.0%})")
        sys.stderr.flush()
        self._begun = True

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._begun:
            sys.stderr.write("\n")
