"""The messages of an MCAP log in the order of the file, within bounds of memory."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

import lz4.frame  # mcap requires both
import zstandard
from mcap.records import Channel, Chunk, McapRecord, Message
from mcap.stream_reader import StreamReader, breakup_chunk

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.text_file import LARGEST

_LARGEST_CHUNK = 2**28  # unpacked [bytes]: writers make chunks of some MB


class LogMessage(NamedTuple):
    """A message of a log: its topic, how it is encoded, its log time [ns], and its bytes."""

    topic: str
    encoding: str
    time: int
    data: bytes


def read_messages(path: Path) -> Iterator[LogMessage]:
    """Messages of a log one after another, without its index.

    Raises:
        RecordingError: no MCAP, or one that unpacks to more than a recording may have.
    """
    channels: dict[int, Channel] = {}
    try:
        with path.open("rb") as file:
            for record in _records(file):
                if isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Message):
                    channel = channels.get(record.channel_id)
                    if channel is None:
                        raise RecordingError(f"a message of channel {record.channel_id}, unknown")
                    yield LogMessage(
                        channel.topic, channel.message_encoding, record.log_time, record.data
                    )
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from None
    # the reader raises whatever its parts do: struct.error, KeyError, ZstdError, OverflowError, …
    except Exception as error:
        raise RecordingError(f"{path}: not an MCAP: {error or type(error).__name__}") from error


def _records(file: BinaryIO) -> Iterator[McapRecord]:
    """Records of a log, those in chunks among them."""
    unpacked = 0
    for record in StreamReader(file, emit_chunks=True, record_size_limit=LARGEST).records:
        if not isinstance(record, Chunk):
            yield record
            continue
        unpacked += record.uncompressed_size
        if record.uncompressed_size > _LARGEST_CHUNK:
            raise RecordingError(
                f"a chunk unpacks to {record.uncompressed_size} bytes, more than {_LARGEST_CHUNK};"
                " record in smaller chunks"
            )
        if unpacked > LARGEST:
            raise RecordingError(
                f"its chunks unpack to more than {LARGEST} bytes; split the recording"
            )
        yield from breakup_chunk(_unpacked(record), validate_crc=True)


def _unpacked(chunk: Chunk) -> Chunk:
    """A chunk without compression, bounded by the size that it says; mcap has no bound."""
    most = chunk.uncompressed_size + 1
    if chunk.compression == "zstd":
        data = zstandard.ZstdDecompressor().stream_reader(io.BytesIO(chunk.data)).read(most)
    elif chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=most)
    elif chunk.compression:
        raise RecordingError(
            f"a chunk is compressed by {chunk.compression!r}; zstd and lz4 are read"
        )
    else:
        data = chunk.data
    if len(data) != chunk.uncompressed_size:
        raise RecordingError(
            f"a chunk unpacks to another size than {chunk.uncompressed_size} bytes"
        )
    return dataclasses.replace(chunk, compression="", data=data)
