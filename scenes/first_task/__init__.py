"""Other first tasks than the distance of two arms."""
