"""Tasks of the arms and the ball: each asks for velocities of some joints; one kind a file."""
