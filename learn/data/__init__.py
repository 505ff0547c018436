"""The data loader: multi-view samples of a data set, their ground truth, augmentation and batches."""
