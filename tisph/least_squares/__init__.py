"""Least-squares operators: derivatives that are exact for polynomials on any arrangement of particles."""
