"""First tasks: values that must not fall below a threshold, with their rows."""
