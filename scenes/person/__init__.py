"""A person in front of the robots: two arms as four angles each, where they come from, and what they ask of the robots."""
