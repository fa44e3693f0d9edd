"""How far a batch is, and how long it still takes."""

from __future__ import annotations

from dataclasses import dataclass, replace

_ENOUGH = 3
"""Recordings that have to be baked before a time is told."""


@dataclass(frozen=True, slots=True)
class Progress:
    """What is done of a batch, and what waits; work is measured by the bytes of the recordings."""

    total: int
    waiting_bytes: int
    """Of all that is not done, what is being baked included."""
    workers: int
    done: int = 0
    baked: int = 0
    """Of those done, the ones that took work: not kept from an earlier run, and not refused."""
    baked_bytes: int = 0
    baked_seconds: float = 0.0
    """Of all workers together."""

    def after(self, size: int, seconds: float, *, baked: bool) -> Progress:
        """The progress once a recording is done.

        Args:
            size: bytes of its file.
            seconds: that a worker spent on it.
            baked: whether it was baked; what was kept or refused says nothing of the others.
        """
        waiting = max(self.waiting_bytes - size, 0)
        if not baked:
            return replace(self, done=self.done + 1, waiting_bytes=waiting)
        return replace(
            self,
            done=self.done + 1,
            waiting_bytes=waiting,
            baked=self.baked + 1,
            baked_bytes=self.baked_bytes + size,
            baked_seconds=self.baked_seconds + seconds,
        )

    def seconds_left(self) -> float | None:
        """Seconds of the clock until all is done; None as long as too little is known.

        What waits takes as long for each byte as what is baked took, on all workers at once.
        """
        if self.done == self.total:
            return 0.0
        if self.baked < max(_ENOUGH, self.workers) or self.baked_bytes == 0:
            return None
        busy = min(self.workers, self.total - self.done)
        return self.baked_seconds / self.baked_bytes * self.waiting_bytes / busy

    def in_words(self, elapsed: float) -> str:
        """A line for people.

        Args:
            elapsed: seconds since the start.
        """
        left = self.seconds_left()
        ending = "time left not known yet" if left is None else f"about {duration(left)} left"
        rate = f"{self.baked / elapsed * 60.0:.3g} per minute, " if self.baked and elapsed > 0.0 else ""
        width = len(str(self.total))
        return f"[{self.done:{width}}/{self.total}] {rate}{ending if self.done < self.total else 'done'}"


def duration(seconds: float) -> str:
    """A time with as many digits as an estimate has."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 90.0 * 60.0:
        return f"{seconds / 60.0:.0f} min"
    hours = seconds / 3600.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"
