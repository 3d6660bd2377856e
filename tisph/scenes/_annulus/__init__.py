"""The annulus between two cylinders."""
