"""The command line, a module per command. Each is wiring: options in, a table or a line out."""
