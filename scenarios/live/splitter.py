"""Frame boundaries in a stream of bytes, whatever its segments are and whatever happened to it on the way.

SYNC (AA hex) may stand anywhere in a frame, and FRAMESIZE may be corrupt: neither can be trusted. So a place is a
frame if as many bytes as it announces are there and CHK is right. If they are not all there yet, it may be one; but a
whole frame after that place proves that it is not. An intact frame therefore comes out as soon as its last byte is
there, and no corrupt one can hold it back.
"""

from . import c37118

AT_START = 4
"""Bytes from SYNC to FRAMESIZE."""


class Splitter:
    def __init__(self):
        self.buffer = bytearray()
        self.skipped = 0
        """Bytes so far that belonged to no intact frame."""

    def feed(self, received: bytes) -> list[bytes]:
        """The intact frames that end in these bytes, in their order."""
        self.buffer += received
        frames = []
        place = 0  # up to which the buffer is done with
        while (found := self.next_start(place)) is not None:
            frame = self.whole_at(found)
            if frame is None and self.may_become_whole(found):
                later = self.first_whole_after(found)
                if later is None:
                    self.skipped += found - place
                    place = found
                    break
                found, frame = later
            self.skipped += found - place
            place = found
            if frame is None:
                self.skipped += 1
                place += 1
            else:
                frames.append(frame)
                place += len(frame)
        else:
            self.skipped += len(self.buffer) - place
            place = len(self.buffer)
        del self.buffer[:place]
        return frames

    def next_start(self, place: int) -> int | None:
        """Where a frame may start, at `place` or later; the last bytes may be the beginning of a start."""
        while (place := self.buffer.find(b"\xaa", place)) >= 0:
            start = self.buffer[place : place + AT_START]
            if len(start) < AT_START or c37118.is_start(start):
                return place
            place += 1
        return None

    def end(self, start: int) -> int:
        return start + c37118.size_announced(self.buffer[start : start + AT_START])

    def whole_at(self, start: int) -> bytes | None:
        """The intact frame that starts there, if it is all there."""
        if start + AT_START > len(self.buffer) or self.end(start) > len(self.buffer):
            return None
        frame = bytes(self.buffer[start : self.end(start)])
        return frame if c37118.is_intact(frame) else None

    def may_become_whole(self, start: int) -> bool:
        return start + AT_START > len(self.buffer) or self.end(start) > len(self.buffer)

    def first_whole_after(self, start: int) -> tuple[int, bytes] | None:
        place = start
        while (found := self.next_start(place + 1)) is not None:
            if (frame := self.whole_at(found)) is not None:
                return found, frame
            place = found
        return None
