"""Physics: equations of motion, saturation, thruster allocation, and what controllers share. One sample at one instant."""
