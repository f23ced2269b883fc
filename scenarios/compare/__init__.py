"""Peers, side by side on the same frames: python -m scenarios compare.

`model` is what an EKF and a UKF know of the machine, `filterpy_filters` the two on FilterPy, `batch` the same for many
noise seeds and tunings at once, `tuning` how they are tuned, `runs` who runs on which frames, `cost` what a step takes.
"""
