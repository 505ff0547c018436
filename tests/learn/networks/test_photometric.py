"""How alike two pictures are along the planes: against pictures of a wall whose disparity is known."""

from __future__ import annotations

import pytest
import torch

from glassware.learn.networks.photometric import halved, local_contrast, photometric_similarity, seen_by_others

from .walls import BASELINE, DEPTH, DISPARITY, FOCAL, wall_pair

#: Planes with disparities of 40 to 8 px; the fifth lies on the wall.
PLANES = torch.tensor([[FOCAL * BASELINE / disparity for disparity in range(40, 4, -4)]])
ON_WALL = 4


@pytest.fixture
def pair(rng):
    return wall_pair(rng)


def contrast_of(images):
    return local_contrast(halved(images.flatten(0, 1))).unflatten(0, images.shape[:2])


def fine_contrast_of(images):
    return local_contrast(images.flatten(0, 1)).unflatten(0, images.shape[:2])


@pytest.mark.parametrize(("contrast", "finer"), [(contrast_of, 1), (fine_contrast_of, 2)])
def test_pictures_are_alike_at_the_depth_of_the_surface_alone(pair, contrast, finer):
    images, poses, K = pair
    similarity = photometric_similarity(contrast(images), poses, K, PLANES, finer)
    seen = similarity[0, :, 4:-4, 24:-4]  # away from the border, where windows and views end
    assert (seen[ON_WALL] > 0.99).all()
    others = torch.cat([seen[:ON_WALL], seen[ON_WALL + 1 :]])
    assert (others.mean((1, 2)) < 0.6).all()


def test_finer_views_tell_planes_apart_that_are_a_pixel_of_disparity_away(pair):
    """At full size a wall one pixel off is no more alike than one far away; at half size a part of it is."""
    images, poses, K = pair
    near = torch.tensor([[FOCAL * BASELINE / disparity for disparity in (DISPARITY + 1, DISPARITY)]])
    coarse = photometric_similarity(contrast_of(images), poses, K, near)[0, :, 4:-4, 24:-4].mean((1, 2))
    fine = photometric_similarity(fine_contrast_of(images), poses, K, near, 2)[0, :, 4:-4, 24:-4].mean((1, 2))
    assert coarse[1] > 0.99
    assert fine[1] > 0.99
    assert fine[0] < coarse[0] - 0.1


def test_what_the_other_view_does_not_see_is_not_alike(pair):
    images, poses, K = pair
    similarity = photometric_similarity(contrast_of(images), poses, K, PLANES)
    first = DISPARITY // 2
    assert (similarity[0, ON_WALL, :, : first - 1] == 0.0).all()
    assert (similarity[0, ON_WALL, :, first + 1 : -4] > 0.0).all()
    neutral = photometric_similarity(contrast_of(images), poses, K, PLANES, unseen=0.7)
    torch.testing.assert_close(neutral, torch.where(similarity == 0.0, 0.7, similarity))


def test_exposure_and_black_level_of_one_view_do_not_matter(pair):
    images, poses, K = pair
    darker = images.clone()
    darker[:, 1] = 0.1 + 0.6 * images[:, 1]
    similarity = photometric_similarity(contrast_of(darker), poses, K, PLANES)[0, :, 4:-4, 24:-4]
    assert (similarity.argmax(0) == ON_WALL).float().mean() > 0.99
    assert similarity[ON_WALL].mean() > 0.9


def test_only_views_that_see_a_point_count(pair):
    """A third view that sees nothing of the scene changes nothing, and neither does one equal to the second."""
    images, poses, K = pair
    plain = photometric_similarity(contrast_of(images), poses, K, PLANES)
    away = torch.eye(4)
    away[0, 3] = 50.0
    for pose, picture in ((away, images[:, :1]), (poses[0, 1], images[:, 1:])):
        cameras = torch.cat([poses, pose[None, None]], dim=1), K[:, [0, 1, 1]]
        found = photometric_similarity(contrast_of(torch.cat([images, picture], dim=1)), *cameras, PLANES)
        torch.testing.assert_close(found, plain)


def test_a_point_counts_as_seen_by_the_views_whose_image_it_lies_in(pair):
    """The right eye of a pair sees what lies more than the disparity from the left edge; an eye far away nothing."""
    _, poses, K = pair
    away = torch.eye(4)
    away[0, 3] = 50.0
    cameras = torch.cat([poses, away[None, None]], dim=1), K[:, [0, 1, 1]]
    seen = seen_by_others(torch.full((1, 32, 64), DEPTH), *cameras, 2)
    assert (seen[..., : DISPARITY // 2] == 0.0).all()
    assert (seen[..., DISPARITY // 2 :] == 0.5).all()
