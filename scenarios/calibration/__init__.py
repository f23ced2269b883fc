"""Which of a machine's data does a record contradict? Parameters from disturbance records, and playback of them."""
