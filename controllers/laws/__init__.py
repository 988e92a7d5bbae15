"""The laws, one a file: pure functions `(Situation) -> joint velocities`."""
