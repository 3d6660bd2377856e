"""A cell with bodies in it, periodic or between walls: its flow, particles and views, and sections of its config."""
