"""First tasks: a value that must not fall below a threshold, with the row that says how joints change it."""
