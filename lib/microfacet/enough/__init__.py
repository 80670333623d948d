"""Which model is enough: the cheapest that stays within a tolerance of the most complete one."""
