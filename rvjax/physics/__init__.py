"""Physics: equations of motion, saturation, thruster allocation, and the parts that controllers share. For a single sample and
instant."""
