"""The next experiment: the motion that would tell two explanations apart, or a model's parameters."""
