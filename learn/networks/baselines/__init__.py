"""The networks that MVTrans is compared with: SimNet, KeyPose, DenseFusion, and their settings."""
