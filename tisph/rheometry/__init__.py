"""Runs read as rheometers and viscometers: moduli, viscosities, compliances."""
