"""When a recording was made, by the name of its file or of a folder.

A day is 2026-03-01, 2026_03_01 or 20260301, of the years 1990 to 2100; one with separators counts
before digits in a row, which may be a serial number. The time of day follows it, as in ISO 8601:

- behind ``T`` or a space: 14, 14:30, 14-30-05, 143005, with fractions of a second; the hour alone
  behind ``T`` only;
- behind another separator: 14-30 or 14h30, so that the run number of 2026-03-01_0042 is none;
- behind a day without separators: also 1430 and 143005.

A zone, ``Z`` or +02:00, makes it a time in UTC.
"""

from __future__ import annotations

import re
from datetime import datetime, timedelta

from tendon_mj.errors import RecordingError

YEARS = range(1990, 2101)

_SEPARATED = re.compile(r"(?<!\d)(\d{4})([-_])(\d{2})\2(\d{2})(?!\d)")
_COMPACT = re.compile(r"(?<!\d)(\d{4})()(\d{2})(\d{2})(?=(?:\d{4}|\d{6})?(?!\d))")
_HOUR, _SIXTY = r"(?P<hour>[01]\d|2[0-3])", r"[0-5]\d"
_MINUTE, _SECOND = (
    rf"(?P<minute>{_SIXTY})",
    rf"(?P<second>{_SIXTY})(?:[.,](?P<fraction>\d{{1,6}}))?",
)
_ZONE = r"(?P<zone>Z|\+\d{2}[-:]?\d{2}|-\d{2}:?\d{2})?"
_END = rf"{_ZONE}(?!\d)(?P<half>\s?[aApP]\.?[mM]\b)?"
_SEP = "[-_:.hHmM]"
_TIMES = {
    "T": re.compile(rf"T{_HOUR}(?:{_SEP}?{_MINUTE}(?:{_SEP}?{_SECOND})?)?{_END}"),
    " ": re.compile(rf" {_HOUR}{_SEP}?{_MINUTE}(?:{_SEP}?{_SECOND})?{_END}"),
    "-": re.compile(rf"[-_]{_HOUR}{_SEP}{_MINUTE}(?:{_SEP}{_SECOND})?{_END}"),
    "": re.compile(rf"[-_]?{_HOUR}{_SEP}?{_MINUTE}(?:{_SEP}?{_SECOND})?{_END}"),
}


def date_in_name(name: str) -> datetime | None:
    """The date in the name of a file, without its suffix, or of a folder; None without one.

    Raises:
        RecordingError: two days, or a time of day that cannot be read.
    """
    separated = _days(_SEPARATED, name)
    found = separated or _days(_COMPACT, name)
    days = {day for day, _ in found}
    if len(days) > 1:
        told = " and ".join(f"{day:%Y-%m-%d}" for day in sorted(days))
        raise RecordingError(
            f"{name!r} has two days, {told}; leave one, and write it as 2026-03-01, which counts"
            " before digits in a row"
        )
    for day, end in found:
        return day + _time_of_day(name, end, compact=not separated)
    return None


def _days(pattern: re.Pattern[str], name: str) -> list[tuple[datetime, int]]:
    """Days in a name, and where the text behind each begins."""
    found = []
    for match in pattern.finditer(name):
        year, month, day = (int(match[k]) for k in (1, 3, 4))
        if year in YEARS:
            try:
                found.append((datetime(year, month, day), match.end()))
            except ValueError:  # 20261399
                continue
    return found


def _time_of_day(name: str, end: int, *, compact: bool) -> timedelta:
    """Time since midnight, in UTC where there is a zone; none without a time of day."""
    behind = name[end : end + 1]
    match = _TIMES[behind if behind in ("T", " ") else "" if compact else "-"].match(name, end)
    if match is None:
        if re.match(r"T\d", name[end:]):
            raise RecordingError(f"{name!r}: {name[end:]!r} is no time of day, such as T14-30-05")
        return timedelta()
    if match["half"]:
        raise RecordingError(f"{name!r}: write the time of day in 24 hours, as 2026-03-01T14-30")
    parts = match.groupdict()
    hour, minute, second = (int(parts.get(k) or 0) for k in ("hour", "minute", "second"))
    micro = int((parts.get("fraction") or "").ljust(6, "0"))
    time = timedelta(hours=hour, minutes=minute, seconds=second, microseconds=micro)
    return time - _offset(match["zone"], name)


def _offset(zone: str | None, name: str) -> timedelta:
    """What a zone is ahead of UTC."""
    if zone is None or zone == "Z":
        return timedelta()
    hours, minutes = int(zone[1:3]), int(zone[-2:])
    if hours > 14 or minutes > 59:
        raise RecordingError(f"{name!r}: {zone!r} is no time zone, such as Z or +02:00")
    size = timedelta(hours=hours, minutes=minutes)
    return -size if zone.startswith("-") else size
