"""Weights of the losses; loads no torch."""

from __future__ import annotations

from pydantic import Field

from ...core.model import Model

#: Weight of KeyPose's disparity error: the released code takes it over whole windows, columns and rows over half ones.
RELEASED_DISPARITY = 0.25


class LossWeights(Model):
    """Weight of each loss, and the transition of the Huber loss.

    Errors below `huber` give error^2 / (2 huber), so at the 1 m of the released code errors of millimetres have hardly
    a gradient; a small value approaches the absolute error.
    """

    huber: float = Field(
        default=1.0, gt=0.0, description="Depth error where the Huber loss turns from quadratic to linear [m]"
    )

    depth: float = Field(default=1.0, ge=0.0, description="Weight of the Huber loss of the full-size depth [m]")
    small_depth: float = Field(default=1.0, ge=0.0, description="Weight of the Huber loss of the coarse depth [m]")
    unrefined_depth: float = Field(
        default=1.0,
        ge=0.0,
        description="Weight of the Huber loss of the full-size depth before its refinement (with refinement only) [m]",
    )
    object_pixels: float = Field(
        default=1.0,
        gt=0.0,
        le=1000.0,
        description="Weight of a pixel of an object in the depth losses; pixels of table and background have 1",
    )
    planes: float = Field(
        default=1.0, ge=0.0, description="Weight of the cross-entropy over depth planes (windowed readout only)"
    )
    disparity: float = Field(
        default=1.0, ge=0.0, description="Weight of the smooth absolute error of SimNet's disparity, knee 1 px [px]"
    )
    small_disparity: float = Field(
        default=1.0, ge=0.0, description="Weight of the same of its coarse disparity [px of 1/4 of the size]"
    )
    keypoint: float = Field(
        default=1.0, ge=0.0, description="Weight of the squared error of KeyPose's keypoints, over half windows"
    )
    keypoint_disparity: float = Field(
        default=RELEASED_DISPARITY,
        ge=0.0,
        description="Weight of the squared error of their disparity in it, over half windows, beside columns and rows",
    )
    projection: float = Field(
        default=2.5,
        ge=0.0,
        description="Weight of the squared error of its keypoints in other views, over half pictures",
    )
    probability: float = Field(
        default=1e-3, ge=0.0, description="Weight of the probability of its integral head far from keypoints"
    )
    distance: float = Field(
        default=1.0, ge=0.0, description="Weight of DenseFusion's distance between points of the surface [m]"
    )
    refined: float = Field(default=1.0, ge=0.0, description="Weight of the same after its refiner [m]")
    seg: float = Field(default=1.0, ge=0.0, description="Weight of the cross-entropy of semantic classes")
    heatmap: float = Field(default=100.0, ge=0.0, description="Weight of the squared error of the heatmap")
    vertex: float = Field(
        default=0.1, ge=0.0, description="Weight of the absolute error of the vertex field, summed over channels"
    )
    z_centroid: float = Field(
        default=0.1, ge=0.0, description="Weight of the absolute error of the depth of box centres"
    )
    covariance: float = Field(
        default=0.1, ge=0.0, description="Weight of the absolute error of the covariance, summed over channels"
    )
    offset: float = Field(
        default=10.0, ge=0.0, description="Weight of the absolute error of offsets over image height, summed over both"
    )
