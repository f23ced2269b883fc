"""The models of a synchronous machine, one a file."""
