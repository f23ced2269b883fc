"""What the studies and the comparison share: true machines, the noise on their frames, and the observer on arrays.

`frames` is a machine's true frames, PmuChannel's noise on them and the observer on what arrives; `streams` the random
numbers, which belong to a machine and a seed wherever they run; `machines` random ones; `smib_fault` the machine of
the scenario of that name; `sixth_order` what the observer's model leaves out; `ieee39` ten machines. Nothing in here
imports `compare` or `studies`, and these two do not import each other.
"""
