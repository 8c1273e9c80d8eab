"""The settings page: the parameters by section, motor test, calibration with a pin."""
