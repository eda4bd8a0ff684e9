"""Damaged files as hypothesis draws them."""

from collections.abc import Sequence

from hypothesis import strategies as st

WORDS = (
    *(b"", b"nan", b"inf", b"-1", b"0", b"1e999", b"1e-323", b"\n", b"\r", b",", b'"', b"#", b"=", b"."),
    *(b"\0", b"\xff", b"\x1b[2J", b"[[", b"{", b"\xef\xbb\xbf", b"\x7f" * 4, b"\xff" * 8, b"9" * 5000),
)
"""What parsers stumble over."""


@st.composite
def damaged(draw: st.DrawFn, seeds: Sequence[bytes]) -> bytes:
    """A whole file with a few changes: bytes, words, a piece cut out or doubled, or two files in one."""
    content = bytearray(draw(st.sampled_from(seeds)))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(content)))
        stop = min(len(content), start + draw(st.sampled_from((0, 1, 2, 4, 8, 64, len(content)))))
        piece = bytes(content[start:stop])
        other = draw(st.sampled_from(seeds))
        new = st.one_of(
            st.binary(max_size=8),
            st.sampled_from(WORDS),
            st.sampled_from((piece * 2, piece[::-1], other[start:])),
        )
        content[start:stop] = draw(new)
    return bytes(content)
