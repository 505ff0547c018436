from __future__ import annotations

import itertools

import numpy as np
import pytest
import torch

from glassware.learn.networks.semi_global_aggregation import aggregate, lowest

SMALL, LARGE = 0.1, 0.4


def jump_cost(before: np.ndarray, after: np.ndarray) -> float:
    """A jump costs less where the colours differ, and always more than a step."""
    return max(1.5 * SMALL, LARGE / (1.0 + 300.0 * np.abs(after - before).mean()))


def least_to_reach(costs: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """The least cost of any sequence of planes along a line, (n, D) and (n, 3), that ends in each plane at its end.

    All sequences are tried, and paths lose the least cost of the pixel before, as the aggregation takes it off.
    """
    count = costs.shape[1]
    result = np.full(count, np.inf)
    jumps = np.array([jump_cost(*colours[index : index + 2]) for index in range(len(costs) - 1)])
    for planes in itertools.product(range(count), repeat=len(costs)):
        steps = np.abs(np.diff(planes))
        penalty = np.where(steps == 0, 0.0, np.where(steps == 1, SMALL, jumps)).sum()
        total = costs[np.arange(len(costs)), planes].sum() + penalty
        result[planes[-1]] = min(result[planes[-1]], total)
    return result


def test_paths_have_the_least_cost_of_all_sequences_of_planes(rng):
    """Tried one by one from each of the four sides, on a picture of 4 x 3 pixels with 4 planes."""
    costs, image = rng.uniform(size=(2, 4, 3, 4)), rng.uniform(high=0.01, size=(2, 4, 3, 3))
    found = aggregate(torch.from_numpy(costs), torch.from_numpy(image), SMALL, LARGE).numpy()
    for sample, row, column in np.ndindex(2, 4, 3):
        lines = (costs[sample, row], image[sample, row]), (costs[sample, :, column], image[sample, :, column])
        expected = np.zeros(4)
        for (line, colours), at in zip(lines, (column, row), strict=True):
            for part in (slice(at + 1), slice(None, at - 1 if at else None, -1)):
                path, along = line[part], colours[part]
                before = least_to_reach(path[:-1], along[:-1]).min() if len(path) > 1 else 0.0
                expected += least_to_reach(path, along) - before
        np.testing.assert_allclose(found[sample, row, column], expected, err_msg=f"{sample}, {row}, {column}")


def test_what_has_no_texture_gets_the_plane_of_what_lies_beside_it():
    costs = torch.full((1, 9, 20, 8), 0.5)
    costs[:, :, :3, 5] = costs[:, :, -3:, 5] = 0.0  # only the sides match, in plane 5
    assert lowest(costs)[0, 4, 10] != 5.0
    found = lowest(aggregate(costs, torch.zeros(1, 9, 20, 3), SMALL, LARGE))
    torch.testing.assert_close(found, torch.full((1, 9, 20), 5.0))


def test_an_edge_of_depth_stays_where_it_is():
    costs = torch.ones(1, 6, 16, 8)
    costs[:, :, :7, 1] = costs[:, :, 7:, 6] = 0.0
    found = lowest(aggregate(costs, torch.zeros(1, 6, 16, 3), SMALL, LARGE)).round()
    assert (found[..., :7] == 1.0).all()
    assert (found[..., 7:] == 6.0).all()


@pytest.mark.parametrize("edge", [8, 10, 12])
def test_where_nothing_matches_depth_jumps_at_the_edge_of_colours(edge):
    """Between two sides that match in different planes lie 7 columns that match in none."""
    costs, image = torch.full((1, 6, 20, 8), 0.5), torch.full((1, 6, 20, 3), 0.4)
    costs[:, :, :7, 1] = costs[:, :, 14:, 6] = 0.0
    image[:, :, edge:] = 0.5
    found = lowest(aggregate(costs, image, SMALL, 4.0)).round()
    assert (found[..., :edge] == 1.0).all()
    assert (found[..., edge:] == 6.0).all()


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
