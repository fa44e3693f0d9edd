"""Training of body-orientation predictors; the only part of Footwork that needs torch.

`job.train_predictor` is the way in. torch itself is imported by `paper`, `window` and `torch_networks` alone, and only
once a training starts.
"""
