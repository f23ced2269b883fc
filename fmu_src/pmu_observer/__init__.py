"""The equations of the observers and of the plants: pure functions, no FMI, standard library only.

Start reading at `observer` (Proposition 2, put together), `phasors` (Lemma 2), `gpebo` (Lemma 3), `estimators/drem`.
"""
