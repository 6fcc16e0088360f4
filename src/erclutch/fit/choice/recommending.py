"""Which model is recommended, and which others are as good for all that some rows can tell."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from erclutch.fit.choice.scoring import TOLERATED, BandedFigure, Score


def as_good(scores: Mapping[str, Score], excesses: Mapping[str, BandedFigure]) -> list[str]:
    """The models that are as good as the best one.

    The test error lies within the best one's band, and on the same blocks of rows it is not more than 5 % larger or
    cannot be told from it.

    Args:
        scores: test score by model.
        excesses: how much larger the test error is than the best one's, by model.
    """
    best = min(scores, key=lambda name: scores[name].rmse.value)
    good: list[str] = []
    for name, of_model in scores.items():
        in_band = of_model.rmse.value <= scores[best].rmse.high
        little_more = excesses[name].value <= TOLERATED
        cannot_be_told = excesses[name].low <= 0.0
        if in_band and (little_more or cannot_be_told):
            good.append(name)
    return good


def recommend(
    scores: Mapping[str, Score],
    excesses: Mapping[str, BandedFigure],
    burden: Mapping[str, float] | Mapping[str, tuple[float, float]],
    sound: Collection[str] | None = None,
    freedom: Mapping[str, int] | None = None,
) -> tuple[str, str]:
    """The best model, and the simplest one that is as good for all these rows can tell.

    Of models that are as good, one that physics binds beyond its rows goes first: a law, then a law with a network,
    then a network, which knows nothing where it saw nothing. Among these the one with the least burden goes first.

    Args:
        scores: test score by model.
        excesses: how much larger the test error is than the best one's, by model.
        burden: number of parameters by model, or another measure of which less is better, or two: the second decides
            where the first is equal.
        sound: models that may be recommended; None or none of them: all.
        freedom: how far a model is free of physics beyond its rows: a law 0, a law with a network 1, a network 2.

    Returns:
        (best, recommended); among equally simple ones the more accurate.
    """
    best = min(scores, key=lambda name: scores[name].rmse.value)
    allowed = [name for name in scores if sound is None or name in sound] or list(scores)
    good = [name for name in as_good(scores, excesses) if name in allowed]
    # Where no sound model comes near the best one, the nearest of them is still the one to use.
    nearest = min(allowed, key=lambda name: scores[name].rmse.value)
    free = freedom or {}

    def order(name: str) -> tuple[int, float | tuple[float, float], float]:
        return free.get(name, 0), burden[name], scores[name].rmse.value

    return best, min(good or [nearest], key=order)
