# SPDX-License-Identifier: Apache-2.0
"""How long frames take."""
from __future__ import annotations


class ServiceTime:
    """The time from sending a frame to its outcome, learned as TCP learns its timeout (RFC 6298, section 2).
    Seconds."""

    def __init__(self) -> None:
        self._mean: float | None = None
        self._deviation = 0.0

    def add(self, took: float) -> None:
        """A frame took so long."""
        if self._mean is None:
            self._mean, self._deviation = took, took / 2
            return
        off = took - self._mean
        self._deviation += (abs(off) - self._deviation) / 4
        self._mean += off / 8

    def add_at_least(self, time: float) -> None:
        """A frame took at least so long, and was given up then."""
        if self._mean is None or time > self._mean:
            self.add(time)

    def bound(self) -> float:
        """A time that few frames exceed; 0 if none has come yet."""
        return 0.0 if self._mean is None else self._mean + 4 * self._deviation
