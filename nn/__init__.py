"""Body orientation from three trackers: inputs, inference in numpy, weights, training."""
