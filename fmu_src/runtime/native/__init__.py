"""The native FMU: any model as C, with no Python inside."""
