"""Machine data: machines.csv, and what planning programs know of a machine (PSS/E's .dyr and .raw)."""
