"""The pin model's workshop: synthetic pictures, training, export and evaluation. Nothing at run time imports it."""
