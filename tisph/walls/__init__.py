"""Wall treatments: what the particles see beyond a no-slip wall. One file each."""
