"""Components: the plug-in families. A family is a package; a member is one file and one line in the family's table."""
