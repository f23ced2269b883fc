"""What wanders and comes back: n' = -n/tau + white noise, with a standard deviation sigma in the long run."""

from math import exp, sqrt


def step(n, h, tau, sigma, w):
    """n(t + h) = a n + sigma sqrt(1 - a^2) w, a = e^(-h/tau), exactly for any h; w is a normal number of its own."""
    a = exp(-h / tau)
    return a * n + sigma * sqrt(1 - a * a) * w
