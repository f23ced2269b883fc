"""What the observer is tried on, one plant a file."""
