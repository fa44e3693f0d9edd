"""How a predictor is trained: every control with default, bounds and help."""

from __future__ import annotations

from dataclasses import dataclass

from ..core.settings import setting

CHECKPOINT = ".training"
"""What the name of a checkpoint adds to that of the weights beside which it lies."""


@dataclass(frozen=True, slots=True)
class TrainSettings:
    """How a body-orientation predictor is trained."""

    kind: str = setting(
        "look-ahead",
        "Kind",
        "What the predictor sees",
        choices={
            "look-ahead": "Windows around each moment, past and future: best for baking recordings",
            "causal": "Windows of the past alone",
            "paper": "The paper's network: the moment itself and its own last answer",
        },
    )
    iterations: int = setting(
        50,
        "Iterations",
        "Predictions in a row before the paper's network is compared with the truth",
        low=1,
        high=500,
    )
    voters: int = setting(
        1, "Voters", "Window networks trained one after the other, whose answers are averaged", low=1, high=8
    )
    epochs: int = setting(
        0,
        "Epochs",
        "Times that every frame is learnt from; 0 for what is usual for the kind",
        low=0,
        high=10000,
    )
    batch: int = setting(
        0, "Batch", "Frames per optimisation step; 0 for what is usual for the kind", low=0, high=65536
    )
    hidden: int = setting(
        0,
        "Hidden Width",
        "Width of the first hidden layer (the second's is the same in the paper's network, else half of it); "
        "0 for what is usual for the kind",
        low=0,
        high=4096,
    )
    learning_rate: float = setting(
        0.0, "Learning Rate", "Step size of AdamW; 0 for what is usual for the kind", low=0.0, high=1.0
    )
    decay: float = setting(
        0.035, "Weight Decay", "How strongly AdamW pulls weights to zero", low=0.0, high=10.0
    )
    held_out: float = setting(
        0.15, "Held Out", "Share of the takes kept from training to measure the error on", low=0.01, high=0.9
    )
    patience: int = setting(
        8, "Patience", "Stop after this many measurements without a better held-out error", low=1, high=1000
    )
    time_limit: float = setting(
        300.0, "Time Limit", "Stop after this long and keep the best so far", low=1.0, high=86400.0, unit="s"
    )
    seed: int = setting(0, "Seed", "Same seed, same takes, same result", low=0, high=2**31 - 1)
    trials: int = setting(
        0,
        "Trials",
        "Trainings with drawn hidden width, learning rate and weight decay, of which the best is kept (needs "
        "optuna); 0 for one training as set",
        low=0,
        high=10000,
    )
    resume: bool = setting(
        False,
        "Resume",
        "Go on with the training of this output file that was cut short, or else from the file's weights",
    )
    keep_worse: bool = setting(
        False, "Keep Worse", "Save even a predictor that is worse than the headset's forward"
    )
