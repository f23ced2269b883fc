"""What turns any `Model` into an FMU: nothing in here knows a model by name."""
