"""A class of students around one lesson: who is there, what they predict, who explores, and how they find the way. No viser here."""
