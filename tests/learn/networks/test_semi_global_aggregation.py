from __future__ import annotations

import itertools

import numpy as np
import torch

from glassware.learn.networks.semi_global_aggregation import aggregate, lowest

SMALL, LARGE = 0.1, 0.4


def least_to_reach(costs: np.ndarray) -> np.ndarray:
    """The least cost of any sequence of planes along a line (n, D) that ends in each plane of its last pixel.

    All sequences are tried, and paths lose the least cost of the pixel before, as the aggregation takes it off.
    """
    count = costs.shape[1]
    result = np.full(count, np.inf)
    for planes in itertools.product(range(count), repeat=len(costs)):
        steps = np.abs(np.diff(planes))
        penalty = np.where(steps == 0, 0.0, np.where(steps == 1, SMALL, LARGE)).sum()
        total = costs[np.arange(len(costs)), planes].sum() + penalty
        result[planes[-1]] = min(result[planes[-1]], total)
    return result


def test_paths_have_the_least_cost_of_all_sequences_of_planes(rng):
    """Tried one by one from each of the four sides, on a picture of 4 x 3 pixels with 4 planes."""
    costs = rng.uniform(size=(2, 4, 3, 4))
    found = aggregate(torch.from_numpy(costs), SMALL, LARGE).numpy()
    for sample, row, column in np.ndindex(2, 4, 3):
        lines = costs[sample, row], costs[sample, :, column]
        expected = np.zeros(4)
        for line, at in zip(lines, (column, row), strict=True):
            for path in (line[: at + 1], line[at:][::-1]):
                before = least_to_reach(path[:-1]).min() if len(path) > 1 else 0.0
                expected += least_to_reach(path) - before
        np.testing.assert_allclose(found[sample, row, column], expected, err_msg=f"{sample}, {row}, {column}")


def test_what_has_no_texture_gets_the_plane_of_what_lies_beside_it():
    costs = torch.full((1, 9, 20, 8), 0.5)
    costs[:, :, :3, 5] = costs[:, :, -3:, 5] = 0.0  # only the sides match, in plane 5
    assert lowest(costs)[0, 4, 10] != 5.0
    torch.testing.assert_close(lowest(aggregate(costs, SMALL, LARGE)), torch.full((1, 9, 20), 5.0))


def test_an_edge_of_depth_stays_where_it_is():
    costs = torch.ones(1, 6, 16, 8)
    costs[:, :, :7, 1] = costs[:, :, 7:, 6] = 0.0
    found = lowest(aggregate(costs, SMALL, LARGE)).round()
    assert (found[..., :7] == 1.0).all()
    assert (found[..., 7:] == 6.0).all()


def test_the_lowest_point_of_a_parabola_is_found_between_planes():
    planes = torch.arange(9.0)
    at = torch.tensor([[2.5, 3.3], [4.0, 6.9]])
    torch.testing.assert_close(lowest((planes - at[..., None]).square()[None])[0], at)


def test_flat_costs_and_those_at_an_end_give_a_plane_of_the_sweep():
    flat, falling = torch.ones(1, 2, 2, 5), torch.arange(5.0, 0.0, -1.0).expand(1, 2, 2, 5)
    for costs in (flat, falling):
        found = lowest(costs)
        assert (found >= 0.0).all()
        assert (found <= 4.0).all()
    assert (lowest(falling) >= 3.0).all()
