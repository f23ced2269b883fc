"""Co-simulation scenarios: one TOML file each, run by one master on FMPy.

    scenario.py     what a file may hold; loader.py reads it   master.py          the co-simulation
    expression.py   "observer.e1d - plant.e1d [pu]"            expectations.py    [[expect]], judged
    component.py    what can be run: fmu.py, record.py         figures.py         [[figure]], drawn
    plan.py         a scenario ready to run, made by           report.py          table, CSV, JSON summary
                    lookup.py, wiring.py and signals.py        study.py           all of it, for one scenario

Adding a scenario is adding a file: `python -m scenarios list` and the tests find it.
"""
