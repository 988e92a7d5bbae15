"""The league of laws: who takes part, what is kept of their runs, and what is shown of it."""
