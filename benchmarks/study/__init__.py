"""The study of docs/study.md: controllers with searched gains under every kind of fault, on the same draws."""
