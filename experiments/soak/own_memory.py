"""Memory of a process that a leak would show in."""

import psutil


def own_memory() -> int:
    """Resident memory of this process [bytes], but for pages of files, which come and go."""
    memory = psutil.Process().memory_info()
    return int(memory.rss - getattr(memory, "shared", 0))  # which Linux alone tells
