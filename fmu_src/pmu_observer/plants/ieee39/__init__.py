"""The IEEE 39-bus (New England) system of Hiskens 2013: ten machines with AVR and PSS. This plant runs on numpy.

The tables are the CSV files in this folder, with their sources in their first lines; all on 100 MVA, 60 Hz, in seconds.
Generator k is at bus (39, 31, 32, 33, 34, 35, 36, 37, 38, 30)[k - 1]; the slack is bus 31.
"""
