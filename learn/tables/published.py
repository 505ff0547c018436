"""Figures that were published, by table, row and column, and where.

MVTrans: Wang et al., "MVTrans: Multi-View Perception of Transparent Objects", ICRA 2023, tables I and II, for its own
rows, and for those of SimNet, KeyPose and DenseFusion, as it states them. KeyPose's 9.9 mm and DenseFusion's 35.1 mm
have the ratio that the abstract of KeyPose (Liu et al., CVPR 2020) gives, so both are most likely copied from there:
means over one model for each object. SimNet's depth error of 1.229 m is most likely that of a fault: its code there
learnt metric depth as a disparity of 22 steps.
"""

from __future__ import annotations

from dataclasses import dataclass

#: Percent, percent, millimetres, percent, percent.
_KEYPOSE_COLUMNS = ("auc", "near", "mae")
_SYN_TODD_COLUMNS = ("rmse", "mae", "rel", "ap25", "iou_found", "ap50", "mask_iou")

KEYPOSE: dict[str, dict[str, float]] = {
    name: dict(zip(_KEYPOSE_COLUMNS, values, strict=True))
    for name, values in {
        "densefusion-true": (71.9, 37.5, 35.1),
        "densefusion-raw": (63.8, 18.9, 37.2),
        "simnet": (87.9, 83.1, 12.6),
        "keypose": (90.0, 90.1, 9.9),
        "mvtrans-2": (92.7, 93.6, 7.4),
        "mvtrans-3": (92.1, 92.8, 8.0),
        "mvtrans-5": (92.9, 94.0, 7.2),
    }.items()
}
KEYPOSE["mvtrans-2"]["iou_found"] = 61.4
KEYPOSE["mvtrans-5"]["ap25"] = 92.2

#: RMSE and MAE in metres, REL as a fraction, the rest in percent.
SYN_TODD: dict[str, dict[str, float]] = {
    name: dict(zip(_SYN_TODD_COLUMNS, values, strict=True))
    for name, values in {
        "simnet": (1.229, 1.020, 0.975, 4.65, 34.92, 48.21, 50.52),
        "mvtrans-2": (0.134, 0.089, 0.135, 40.79, 45.95, 84.94, 79.52),
        "mvtrans-3": (0.125, 0.083, 0.125, 42.53, 46.17, 87.75, 81.89),
        "mvtrans-5": (0.124, 0.080, 0.117, 46.99, 48.44, 87.24, 81.30),
    }.items()
}


@dataclass(frozen=True)
class PublishedDataset:
    """What the authors of a data set say of it; None where they do not."""

    name: str
    samples: str
    objects: str
    scenes: str
    annotations: str
    source: str


DATASETS = (
    PublishedDataset(
        "Syn-TODD",
        "1,996 scenes of 57 views",
        "7,010 vessels, 9,012 opaque",
        "1,996",
        "stereo, depth, masks, boxes, poses, keypoints, normals",
        "MVTrans, ICRA 2023",
    ),
    PublishedDataset(
        "KeyPose (TOD)", "48,000", "15", "600", "stereo, depth, masks, keypoints", "Liu et al., CVPR 2020"
    ),
    PublishedDataset("ClearPose", "over 350,000", "63", "51", "depth, masks, poses", "Chen et al., ECCV 2022"),
    PublishedDataset("TransCG", "57,715", "51", "130", "depth, masks, poses", "Fang et al., RA-L 2022"),
    PublishedDataset("TODD", "about 15,000", "not stated", "not stated", "depth, masks, poses", "Xu et al., CoRL 2021"),
    PublishedDataset("Trans10K-v2", "10,428", "11 classes", "10,428", "classes", "Xie et al., IJCAI 2021"),
)
