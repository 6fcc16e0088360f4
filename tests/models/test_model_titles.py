"""Titles in plain words tell the models of a ranking apart."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.models.laws import ladder
from erclutch.models.model_titles import id_of, title_of, titles_of
from erclutch.models.stages import shown_stages


@pytest.mark.parametrize(
    ("name", "title"),
    [
        (
            "casson+fnn-16+rise-fall+inertia+effort-lag+dahl-2/field",
            "Casson law with a network, lags and memory",
        ),
        ("bingham", "Bingham law"),
        ("bingham/critical/forward+lag", "Bingham law (critical yield) (one direction) with a lag"),
        ("cho-choi-jhon", "Cho-Choi-Jhon law"),
        ("rbfm-10", "RBFM law (10 kernels)"),
        ("quadratic", "Quadratic law in E"),
        ("fnn-10-6", "Network of 10 and 6 neurons"),
        ("rbfn-1/kmeans", "Radial network of 1 neuron, kmeans"),
        ("bingham+dahl/field+stiffness", "Bingham law with memory and a spring"),
        ("bingham+sides", "Bingham law with two sides"),
        ("bingham+stribeck-1+sides", "Bingham law with a Stribeck hump and two sides"),
        ("bingham+lag+viscous+knees", "Bingham law with a lag, a power of the slip and knees"),
        ("bingham+sides+dahl", "Bingham law with memory"),
        ("bingham+lag@recalibrated", "Bingham law with a lag, recalibrated"),
        ("law-that-is-not-here+stage-too", "Law-that-is-not-here law with stage-too"),
    ],
)
def test_a_title_says_what_stands_beside_the_law(name: str, title: str) -> None:
    assert title_of(name) == title


def test_titles_that_would_be_the_same_name_what_differs() -> None:
    names = [
        "casson+rise-fall+lugre/field+inertia",
        "casson+rise-fall+lugre/field",
        "casson+dahl",
        "casson+dahl/field",
        "bingham+lag",
    ]
    assert list(titles_of(names).values()) == [
        "Casson law with lags and memory (lugre, inertia)",
        "Casson law with lags and memory (lugre)",
        "Casson law with memory (dahl)",
        "Casson law with memory (dahl/field)",
        "Bingham law with a lag",
    ]


_PARTS = ["fnn-16", "fnn-8", *(stage.name for stage in shown_stages())]
_NAMES = st.builds(
    lambda law, parts: "+".join([law, *parts]),
    st.sampled_from([*ladder(), "bingham/critical/forward", "fnn-6"]),
    st.lists(st.sampled_from(_PARTS), max_size=4, unique=True),
)


@pytest.mark.slow
@given(st.lists(_NAMES, min_size=2, max_size=12, unique=True))
def test_no_two_models_of_a_ranking_have_the_same_title(names: list[str]) -> None:
    titles = titles_of(names)
    assert list(titles) == names
    assert len(set(titles.values())) == len(names)
    assert titles_of(names[::-1]) == titles


def test_an_id_is_the_place_in_the_ranking() -> None:
    assert [id_of(place) for place in (0, 9)] == ["m1", "m10"]
