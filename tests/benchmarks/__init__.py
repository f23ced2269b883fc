CASES = [f"{kind} {what}" for kind in ("native", "python") for what in ("nothing", "drem", "robust")]
CYCLES = 1000
"""Of a case, in a round."""
