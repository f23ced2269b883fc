"""Frame boundaries, found in any segmentation and behind any damage."""

import random

from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.live import c37118
from scenarios.live.c37118 import Stamp
from scenarios.live.splitter import Splitter

from .frames import configuration, data

CONFIGURATION = configuration()
DAMAGES = ["bit", "cut", "insert"]
LAYOUT = c37118.layout(CONFIGURATION)


def stream(count: int) -> list[bytes]:
    """Data frames with a configuration and a header among them."""
    frames = [c37118.encode_data(data(CONFIGURATION, number), LAYOUT) for number in range(count)]
    frames.insert(count // 2, c37118.encode_configuration(CONFIGURATION))
    frames.insert(count // 3, c37118.encode_header(7, Stamp(1), "Station 1"))
    return frames


def fed(segments) -> list[bytes]:
    splitter = Splitter()
    return [frame for segment in segments for frame in splitter.feed(segment)]


def cut(whole: bytes, at) -> list[bytes]:
    places = [0, *sorted(place % (len(whole) + 1) for place in at), len(whole)]
    return [whole[a:b] for a, b in zip(places, places[1:], strict=False)]


@given(st.lists(st.integers(0, 10**6), max_size=40))
def test_any_segmentation(places):
    frames = stream(12)
    assert fed(cut(b"".join(frames), places)) == frames


def test_a_frame_is_there_with_its_last_byte():
    splitter = Splitter()
    for frame in stream(6):
        found = [splitter.feed(frame[k : k + 1]) for k in range(len(frame))]
        assert found == [*[[]] * (len(frame) - 1), [frame]]
    assert not splitter.buffer and splitter.skipped == 0


def test_a_corrupt_size_holds_back_nothing():
    """FRAMESIZE of FFFF hex: waiting for it would silence the stream for hundreds of frames."""
    frames = stream(10)
    broken = bytearray(frames[4])
    broken[2:4] = b"\xff\xff"
    splitter = Splitter()
    found = [splitter.feed(frame) for frame in [*frames[:4], bytes(broken), *frames[5:]]]
    assert found == [*([frame] for frame in frames[:4]), [], *([frame] for frame in frames[5:])]
    assert splitter.skipped == len(broken)


def test_what_is_kept_is_bounded():
    """Endless starts of frames of 65535 bytes that never come."""
    splitter = Splitter()
    for _ in range(40):
        assert splitter.feed(b"\xaa\x02\xff\xff" + bytes(5000)) == []
        assert len(splitter.buffer) <= c37118.LARGEST + 5004


def damaged(frame: bytes, how: str, draw: random.Random) -> bytes:
    place = draw.randrange(len(frame))
    if how == "bit":
        changed = bytearray(frame)
        changed[place] ^= 1 << draw.randrange(8)
        return bytes(changed)
    if how == "cut":
        return frame[:place] + frame[place + 1 + draw.randrange(20) :]
    return frame[:place] + draw.randbytes(1 + draw.randrange(20)) + frame[place:]


@settings(max_examples=25)
@given(
    st.integers(0, 2**32), st.sampled_from([1, 7, 200, 1460, 10_000]), st.sampled_from(["bit", "cut", "insert", "all"])
)
def test_every_intact_frame_comes_out(seed, longest, how):
    """5 % of 400 frames are damaged by bit errors, cuts and insertions: the others come out, at once, in their order.

    An insertion before the first byte leaves the frame intact, so that it may come out.
    """
    draw = random.Random(seed)
    frames = stream(400)
    hit = {k for k in range(len(frames)) if draw.random() < 0.05}
    kinds = DAMAGES if how == "all" else [how]
    sent = [damaged(frame, draw.choice(kinds), draw) if k in hit else frame for k, frame in enumerate(frames)]
    splitter, position, found, places = Splitter(), 0, [], []
    whole = b"".join(sent)
    while position < len(whole):
        size = draw.randint(1, longest)
        new = splitter.feed(whole[position : position + size])
        position = min(position + size, len(whole))
        found += new
        places += [position] * len(new)
    intact = [frame for k, frame in enumerate(frames) if k not in hit]
    came = iter(found)
    assert all(any(frame == other for other in came) for frame in intact)
    ends, end = {}, 0
    for frame in sent:
        end += len(frame)
        ends.setdefault(frame, end)
    assert all(place - ends[frame] < longest for frame, place in zip(found, places, strict=True) if frame in intact)


@given(st.binary(max_size=3000))
def test_noise_is_no_frame_and_no_exception(noise):
    frames = stream(3)
    found = fed([noise, *frames])
    assert found[-len(frames) :] == frames
