"""The observers of the speed deviation x2 = omega from the rotor angle."""
