"""What a statement is, and how it is printed, evaluated, proved and enclosed."""
