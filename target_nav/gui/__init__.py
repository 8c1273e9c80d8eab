"""What an operator sees and says: view models in plain Python here, the GTK3 panel in `panels/` and `settings_tabs/`.

A view model turns what is in shared memory into what a screen shows: numbers, texts, points, each with its age. No
screen, no ROS, no decision. The panel and the browser console draw the same ones.
"""
