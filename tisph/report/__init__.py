"""Pictures, movies and tables, without Taichi and without a window."""
