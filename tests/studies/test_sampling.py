"""Points of a study: grids in order, hypercubes with one point a stratum, Sobol's sequence, the same in any block."""

from itertools import product

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from mrts.studies.distributions import Distribution
from mrts.studies.sampling import grid_size, sample_points

QUANTILE_TOLERANCE = 1e-12
"""Share by which two ways to evaluate a quantile may differ: rounding."""

ANY = [
    Distribution("values", (3.0, 1.0, 2.0)),
    Distribution("uniform", (-2.0, 5.0)),
    Distribution("normal", (1.0, 0.1)),
    Distribution("uniform", (0.0, 1e-3)),
]
UNIT = [Distribution("uniform", (0.0, 1.0))] * 5


def test_a_grid_takes_every_combination_the_last_number_fastest():
    distributions = [
        Distribution("values", (1.0, 2.0)),
        Distribution("values", (10.0,)),
        Distribution("values", (0.5, 0.25, 0.125)),
    ]
    assert grid_size(distributions) == 6
    expected = list(product(*(distribution.levels for distribution in distributions)))
    np.testing.assert_array_equal(sample_points(distributions, "grid", 6, 0, (0, 6)), expected)


@pytest.mark.parametrize("sample", ["grid", "lhs", "sobol"])
def test_points_are_the_same_in_any_block(sample):
    distributions = (
        [Distribution("values", tuple(np.linspace(0, 1, levels))) for levels in (7, 5, 4)] if sample == "grid" else ANY
    )
    count = 140
    whole = sample_points(distributions, sample, count, 3, (0, count))
    assert whole.shape == (count, len(distributions))
    rng = np.random.default_rng(1)
    for first, last in np.sort(rng.integers(0, count + 1, (30, 2)), axis=1).tolist():
        if first < last:
            np.testing.assert_array_equal(
                sample_points(distributions, sample, count, 3, (first, last)), whole[first:last]
            )
    if sample != "grid":
        assert np.any(sample_points(distributions, sample, count, 4, (0, count)) != whole)


@pytest.mark.parametrize("count", [1, 7, 64, 1000])
def test_a_latin_hypercube_has_one_point_in_each_part_of_each_number(count):
    points = sample_points(UNIT, "lhs", count, 5, (0, count))
    strata = np.sort(np.minimum((points * count).astype(int), count - 1), axis=0)
    np.testing.assert_array_equal(strata, np.tile(np.arange(count)[:, None], len(UNIT)))
    if count > 500:
        correlation = np.corrcoef(points.T) - np.eye(len(UNIT))
        assert np.max(np.abs(correlation)) < 4 / np.sqrt(count)  # columns are drawn by themselves


def test_sobol_points_are_those_of_scipy():
    ours = sample_points(UNIT, "sobol", 300, 11, (0, 300))
    np.testing.assert_array_equal(ours[:256], qmc.Sobol(5, rng=np.random.default_rng(11)).random(256))
    assert qmc.discrepancy(ours[:256]) < qmc.discrepancy(np.random.default_rng(0).random((256, 5))) / 4


@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Distribution("uniform", (-2.0, 5.0)), stats.uniform(-2, 7)),
        (Distribution("normal", (3.0, 0.2)), stats.norm(3, 0.2)),
        (Distribution("lognormal", (3.0, 0.2)), stats.lognorm(0.2, scale=3)),
        (Distribution("triangular", (1.0, 2.0, 5.0)), stats.triang(0.25, 1, 4)),
    ],
)
def test_quantiles_are_those_of_scipy(distribution, reference):
    probability = np.random.default_rng(2).random(500)
    np.testing.assert_allclose(
        distribution.at(probability), reference.ppf(probability), rtol=QUANTILE_TOLERANCE, atol=1e-15
    )
    ends = distribution.at(np.array([0.0, 1.0]))
    assert np.all(np.isfinite(ends))
    if distribution.bounds is not None:
        assert ends.tolist() == pytest.approx(distribution.bounds)
