"""What is drawn: theme, stage, gizmos, controls, plots, numbers, equation, keys."""
