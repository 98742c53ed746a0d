"""The cogging model against scipy's B-splines, the recursion as printed (eq. 6) and plain numpy sums."""

import numpy as np
import pytest
from scipy.interpolate import BSpline as ScipySpline

import cogging

KNOTS = [(-0.123, 0.0324), (17.5, 2 * np.pi / 72)]  # origin (m), pitch (m)


def knots(order, origin, pitch, control_points):
    """X_1 .. X_(m+k): control point c acts on [origin + (c + 1 - k) pitch, origin + (c + 1) pitch)."""
    return origin + pitch * np.arange(1 - order, control_points + 1)


def printed_recursion(x, j, order, X):
    """N_(j,k)(x) of Lu et al. 2008, eq. 6, j from 0; X are the knots."""
    if order == 1:
        return np.where((x >= X[j]) & (x < X[j + 1]), 1.0, 0.0)
    left = (x - X[j]) / (X[j + order - 1] - X[j]) * printed_recursion(x, j, order - 1, X)
    right = (X[j + order] - x) / (X[j + order] - X[j + 1]) * printed_recursion(x, j + 1, order - 1, X)
    return left + right


def model_of(seed, *, order, control_points, pitch=0.05, origin=0.0, **terms):
    basis = cogging.SplineHarmonics(pitch=pitch, order=order, origin=origin, control_points=control_points, **terms)
    rng = np.random.default_rng(seed)
    shape = (basis.terms, control_points)
    return cogging.CoggingModel(basis, rng.normal(size=shape), rng.normal(size=shape))


def plain_model(model, x, derivative=False):
    """Eq. 3 to 5 with scipy's splines: sum of f_S sin + f_C cos, or its derivative."""
    spline = model.basis.spline
    k, m = spline.order, spline.control_points
    t = knots(k, spline.origin, spline.pitch, m)
    force = np.zeros_like(x)
    for w, s, c in zip(model.basis.wavenumbers, model.sine, model.cosine, strict=True):
        if m == 1:
            f_s, f_c, df_s, df_c = s[0], c[0], 0.0, 0.0
        else:
            inside = np.clip(x, t[k - 1], np.nextafter(t[m], t[0]))
            splines = ScipySpline(t, s, k - 1), ScipySpline(t, c, k - 1)
            (f_s, f_c), (df_s, df_c) = [[f(inside, d) * (inside == x) ** d for f in splines] for d in (0, 1)]
        if derivative:
            force += (df_s - w * f_c) * np.sin(w * x) + (df_c + w * f_s) * np.cos(w * x)
        else:
            force += f_s * np.sin(w * x) + f_c * np.cos(w * x)
    return force


@pytest.mark.parametrize(("origin", "pitch"), KNOTS)
@pytest.mark.parametrize("order", [*range(1, 5), 7, 16])
def test_design_matrix_is_scipys_and_the_printed_recursion(order, origin, pitch):
    for control_points in {max(order, 2), order + 1, order + 10}:
        fields = {"order": order, "origin": origin, "pitch": pitch, "control_points": control_points}
        spline, t = cogging.BSpline(**fields), knots(**fields)
        end = t[control_points]
        assert {name: getattr(spline, name) for name in fields} == fields
        assert spline.end == pytest.approx(end, rel=1e-15, abs=1e-15)
        # Order 1 jumps at its knots: which side a rounded knot lies on is not the spline's affair.
        x = np.random.default_rng(order).uniform(origin, end, 500)
        if order > 1:
            x = np.concatenate([x, t[order - 1 : control_points + 1]]).clip(origin, end)
        expected = ScipySpline.design_matrix(x, t, order - 1).toarray()
        np.testing.assert_allclose(spline.design_matrix(x), expected, rtol=0, atol=1e-12)
        if order <= 4:
            printed = [printed_recursion(x[:50], j, order, t) for j in range(control_points)]
            np.testing.assert_allclose(spline.design_matrix(x[:50]), np.transpose(printed), rtol=0, atol=1e-12)


TERMS = [{"harmonics": [12, 1, 6, 3, 2]}, {"periods": [0.0731, 0.05]}]


@pytest.mark.parametrize("terms", TERMS, ids=str)
@pytest.mark.parametrize(("order", "control_points"), [(1, 8), (2, 11), (3, 13), (5, 9), (3, 1)])
def test_force_and_slope_are_the_plain_sums(terms, order, control_points):
    """Beyond the knots the amplitudes are held and the harmonics go on."""
    model = model_of(3, order=order, control_points=control_points, origin=-0.03, **terms)
    x = np.random.default_rng(4).uniform(-0.2, 1.0, 400).reshape(20, 20)
    terms_count = model.basis.terms
    assert model.force(x)[1, 2] == model.force(float(x[1, 2]))
    np.testing.assert_allclose(model.force(x), plain_model(model, x), rtol=0, atol=1e-12 * terms_count)
    steepest = max(model.basis.wavenumbers) + 1 / 0.05
    np.testing.assert_allclose(
        model.slope(x), plain_model(model, x, derivative=True), rtol=0, atol=1e-12 * terms_count * steepest
    )


def test_coefficients_stand_as_in_eq_7():
    """A_r = [S_11, C_11, S_21, C_21, ..., ]: a control point after the other; the force is A_r^T S_r."""
    model = model_of(14, order=2, control_points=3, harmonics=[1, 4])
    s, c = model.sine, model.cosine
    expected = np.concatenate([[s[0, j], c[0, j], s[1, j], c[1, j]] for j in range(3)])
    np.testing.assert_array_equal(model.coefficients, expected)
    x = np.random.default_rng(15).uniform(0, 0.1, 20)
    N = np.stack([printed_recursion(x, j, 2, knots(2, 0.0, 0.05, 3)) for j in range(3)], axis=1)
    w = 2 * np.pi / 0.05
    shapes = np.stack([np.sin(w * x), np.cos(w * x), np.sin(4 * w * x), np.cos(4 * w * x)], axis=1)
    expected = (N[:, :, None] * shapes[:, None, :]).reshape(20, -1)
    np.testing.assert_allclose(model.basis.regressor(x), expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(model.basis.regressor(x) @ model.coefficients, model.force(x), rtol=0, atol=1e-12)


@pytest.mark.parametrize(("order", "control_points"), [(1, 5), (3, 13), (6, 8), (3, 1)])
def test_active_regressor_is_the_columns_that_are_not_zero(order, control_points):
    basis = model_of(16, order=order, control_points=control_points, harmonics=[1, 3]).basis
    for x in np.random.default_rng(17).uniform(-0.1, 0.7, 50):
        first, active = basis.active_regressor(x)
        assert len(active) == (1 if control_points == 1 else order) * 4
        assert first % 4 == 0
        dense = np.zeros(basis.coefficients)
        dense[first : first + len(active)] = active
        np.testing.assert_array_equal(dense, basis.regressor(np.array([x]))[0])
