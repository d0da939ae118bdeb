"""Components: the plug-in families. A family is a package; each member is a file and a line in the family's `MEMBERS`."""
