"""Another first task than the distance of two arms: the room, what is kept in it, and who moves what."""
