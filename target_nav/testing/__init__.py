"""For those who test missions with pytest: scenario files are collected, and a fixture ticks missions from Python."""
