"""The laws: one a file, all with one signature, `(Situation) -> joint velocities`. A law is pure and knows nothing else."""
