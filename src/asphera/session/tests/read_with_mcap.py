"""Prints what the Python package mcap reads in a session's folder.

First line: number of segments, config.toml in hex and session id, the same in every segment.
Then a line a message, in file order: sequence, log time in ns, topic, data in hex. Every checksum
is verified, and every segment is read twice: from start to end, and by its index.
"""

import pathlib
import sys

from mcap.reader import NonSeekingReader, SeekingReader


def messages(reader):
    return [
        (message.sequence, message.log_time, channel.topic, message.data.hex())
        for _, channel, message in reader.iter_messages(log_time_order=False)
    ]


def main():
    segments = sorted(pathlib.Path(sys.argv[1]).glob("*.mcap"))
    about = set()
    lines = []
    for segment in segments:
        with segment.open("rb") as file:
            linear = messages(NonSeekingReader(file, validate_crcs=True))
        with segment.open("rb") as file:
            reader = SeekingReader(file, validate_crcs=True)
            indexed = messages(reader)
            attachments = {entry.name: entry.data for entry in reader.iter_attachments()}
            (metadata,) = reader.iter_metadata()
            statistics = reader.get_summary().statistics
        if sorted(linear) != sorted(indexed):
            sys.exit(f"{segment}: the index leads to other messages")
        if statistics.message_count != len(linear):
            sys.exit(f"{segment}: the statistics tell another number of messages")
        about.add((attachments["config.toml"].hex(), metadata.metadata["session"]))
        lines += linear
    ((config, session),) = about
    print(len(segments), config, session)
    for line in lines:
        print(*line)


if __name__ == "__main__":
    main()
