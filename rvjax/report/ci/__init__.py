"""Output for continuous integration: JUnit XML, GitHub annotations and the GitHub job summary."""
