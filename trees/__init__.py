"""The missions: data files only. A package, so that `importlib.resources.files("trees")` finds them installed too."""
