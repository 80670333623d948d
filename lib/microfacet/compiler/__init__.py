"""From kernels, functions of plain floats, to compiled loops over arrays."""
