"""Points of a study: grids in order, Sobol's sequence, the same in any block."""

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
    np.testing.assert_array_equal(sample_points(distributions, "grid", 0, (0, 6)), expected)


@pytest.mark.parametrize("sample", ["grid", "sobol"])
def test_points_are_the_same_in_any_block(sample):
    distributions = (
        [Distribution("values", tuple(np.linspace(0, 1, levels))) for levels in (7, 5, 4)] if sample == "grid" else ANY
    )
    count = 140
    whole = sample_points(distributions, sample, 3, (0, count))
    assert whole.shape == (count, len(distributions))
    rng = np.random.default_rng(1)
    for first, last in np.sort(rng.integers(0, count + 1, (30, 2)), axis=1).tolist():
        if first < last:
            np.testing.assert_array_equal(sample_points(distributions, sample, 3, (first, last)), whole[first:last])
    if sample != "grid":
        assert np.any(sample_points(distributions, sample, 4, (0, count)) != whole)


def test_sobol_points_are_those_of_scipy():
    ours = sample_points(UNIT, "sobol", 11, (0, 300))
    np.testing.assert_array_equal(ours[:256], qmc.Sobol(5, rng=np.random.default_rng(11)).random(256))
    assert qmc.discrepancy(ours[:256]) < qmc.discrepancy(np.random.default_rng(0).random((256, 5))) / 4


@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Distribution("uniform", (-2.0, 5.0)), stats.uniform(-2, 7)),
        (Distribution("normal", (3.0, 0.2)), stats.norm(3, 0.2)),
    ],
)
def test_quantiles_are_those_of_scipy(distribution, reference):
    probability = np.random.default_rng(2).random(500)
    np.testing.assert_allclose(
        distribution.at(probability), reference.ppf(probability), rtol=QUANTILE_TOLERANCE, atol=1e-15
    )
    ends = distribution.at(np.array([0.0, 1.0]))
    assert np.all(np.isfinite(ends))
    if distribution.kind == "uniform":
        assert tuple(ends) == pytest.approx(distribution.numbers)
