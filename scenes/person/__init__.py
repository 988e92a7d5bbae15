"""A person who moves the robots' arms."""
