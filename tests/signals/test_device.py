from __future__ import annotations

import numpy as np

from erclutch.signals.device import elements_of


def test_slips_of_the_coaxial_pair_are_equations_5_and_6() -> None:
    theta_dot, alpha_dot = np.array([10.0, 10.0, -2.0]), np.array([0.0, 4.0, 3.0])
    first, second = elements_of(
        "coaxial",
        {"E1": np.ones(3), "E2": np.zeros(3), "theta_dot": theta_dot, "alpha_dot": alpha_dot},
    )
    np.testing.assert_array_equal(first.slip, [10.0, 6.0, -5.0])
    np.testing.assert_array_equal(second.slip, [-10.0, -14.0, -1.0])
    np.testing.assert_array_equal(first.field, 1.0)
    np.testing.assert_array_equal(second.field, 0.0)


def test_signs_where_the_motor_is_faster_than_the_output() -> None:
    """|theta_dot| >= |alpha_dot|: CH1 slips forward and pushes right, CH2 backward and pushes left."""
    rng = np.random.default_rng(0)
    theta_dot = rng.uniform(1, 20, 100)
    alpha_dot = theta_dot * rng.uniform(-1, 1, 100)
    zero = np.zeros(100)
    first, second = elements_of(
        "coaxial", {"E1": zero, "E2": zero, "theta_dot": theta_dot, "alpha_dot": alpha_dot}
    )
    assert np.all(first.slip >= 0)
    assert np.all(second.slip <= 0)
    np.testing.assert_allclose(first.slip + second.slip, -2 * alpha_dot, atol=1e-12)
    np.testing.assert_allclose(first.slip - second.slip, 2 * theta_dot, atol=1e-12)


def test_a_signed_field_drives_one_clutch_at_a_time() -> None:
    speeds = {"theta_dot": np.ones(4), "alpha_dot": np.zeros(4)}
    first, second = elements_of("coaxial", {"E": np.array([0.4, 0.0, -0.2, -0.0]), **speeds})
    np.testing.assert_array_equal(first.field, [0.4, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(second.field, [0.0, 0.0, 0.2, 0.0])


def test_two_fields_come_before_a_signed_one() -> None:
    zero = np.zeros(2)
    first, _ = elements_of(
        "coaxial",
        {"E1": zero + 0.3, "E2": zero, "E": zero - 1, "theta_dot": zero, "alpha_dot": zero},
    )
    np.testing.assert_array_equal(first.field, 0.3)


def test_a_single_element_is_what_was_logged() -> None:
    field, slip = np.array([1.0, 2.0]), np.array([-1.0, 3.0])
    (element,) = elements_of("single", {"field": field, "slip": slip})
    assert element.field is field
    assert element.slip is slip
