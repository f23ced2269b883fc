"""What a scalar is: the equations take one of these modules as their first argument `xp`.

`floats` is the Python FMU, `arrays` runs many machines or noise seeds at once, `symbols` becomes C. Each has the
array-API names (`sin`, `exp`, `where`, `logical_and`, ...) and `cond(c, then, otherwise)`, which takes two functions
without arguments and returns the tree that one of them makes. The equations hold no Python branch on a value.
"""
