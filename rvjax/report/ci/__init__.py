"""What a continuous-integration service reads: JUnit XML, GitHub's annotations and job summary, items of pytest."""
