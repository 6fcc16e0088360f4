"""A second ripple over the position, of a period of its own: a gear beside poles, a bearing beside a gear.

::

    z = x / lambda_q,   columns cos(2 pi k z) and sin(2 pi k z),   k = 1, ..., the number of the stage

It is looked for in what the first ripple leaves.
"""

from __future__ import annotations

from erclutch.models.stages.ripple import Ripple
from erclutch.models.stages.stage import StageFamily

STAGE = StageFamily(
    lambda count, forms: Ripple(count, "second-ripple", "lambda_q", "T_a", "T_b"),
    count=1,
    ladder=("second-ripple", "second-ripple-2", "second-ripple-3"),
    beside="ripple",
)
