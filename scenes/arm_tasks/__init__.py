"""Tasks of the arms and the ball, one kind a file."""
