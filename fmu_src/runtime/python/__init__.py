"""The Python FMU: any model as a pythonfmu slave."""
