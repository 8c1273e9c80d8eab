"""What scripts/setup_environment.py is made of. Standard library only: it runs before anything is installed."""
