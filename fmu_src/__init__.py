"""Sources of the FMUs: the equations, the models made of them, and the runtime that turns a model into an FMU."""
