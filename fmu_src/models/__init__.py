"""The FMUs, one a file: each module declares MODEL. Adding an FMU is adding a file."""
