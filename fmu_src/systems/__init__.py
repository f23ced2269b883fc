"""Systems of FMUs, one a file: each module declares SYSTEM, and becomes an SSP."""
