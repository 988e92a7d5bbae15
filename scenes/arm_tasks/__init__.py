"""Who moves some of the joints, and what they want of them: one kind of mover a file."""
