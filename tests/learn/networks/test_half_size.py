"""Images at half of their size, in which objects may be found."""

from __future__ import annotations

import torch

from glassware.learn.networks.layers import half_size, upsample


def test_new_pixel_i_lies_over_old_pixel_2i():
    """A ramp keeps its values there, but at the edge, whose pixels are repeated."""
    y, x = torch.meshgrid(torch.arange(8.0), torch.arange(12.0), indexing="ij")
    ramp = (3.0 * y - 2.0 * x)[None, None]
    halved = half_size(ramp)
    torch.testing.assert_close(halved[..., 1:, 1:], ramp[..., 2::2, 2::2])
    torch.testing.assert_close(upsample(halved, 2)[..., 2:-1, 2:-1], ramp[..., 2:-1, 2:-1])


def test_weights_are_1_2_1_in_each_direction():
    for row, column, expected in ((4, 6, 0.25), (4, 7, 0.125), (5, 7, 0.0625)):
        image = torch.zeros(1, 1, 8, 12)
        image[..., row, column] = 1.0
        halved = half_size(image)
        assert halved[0, 0, row // 2, column // 2] == expected
        assert halved.sum() == 0.25
