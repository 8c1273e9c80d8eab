"""What the fuzzers of both notations share.

`TARGET_NAV_HYPOTHESIS=random TARGET_NAV_FUZZ_EXAMPLES=20000` looks further than CI does.
"""

from __future__ import annotations

import os
from collections.abc import Sequence

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

EXAMPLES = int(os.environ.get("TARGET_NAV_FUZZ_EXAMPLES", "100"))
FUZZ = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@st.composite
def mutilated(draw: st.DrawFn, seeds: Sequence[str], inserts: Sequence[str]) -> str:
    """One of the texts with pieces cut out, doubled, turned round, or replaced by one of `inserts`."""
    text = draw(st.sampled_from(seeds))
    for _ in range(draw(st.integers(1, 4))):
        begin, end = sorted(draw(st.tuples(st.integers(0, len(text)), st.integers(0, len(text)))))
        piece = text[begin:end]
        text = text[:begin] + draw(st.sampled_from(["", piece * 2, piece[::-1], *inserts])) + text[end:]
    return text
