"""Records as utilities have them, and the project's standard record that everything else works on."""
