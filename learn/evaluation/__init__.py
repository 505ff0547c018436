"""Evaluation of a trained network on a data set, and prediction on images of your own."""
