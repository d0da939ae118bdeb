"""What acts on the page where scripts run: the replay of kept flights in three dimensions, and linked plots of the samples."""
