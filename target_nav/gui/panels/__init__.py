"""What the GTK3 panel draws: one module a pane. A pane draws a view model and decides nothing."""
