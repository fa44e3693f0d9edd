"""Joints of a person recognised by what names mean and how bones hang, where no known naming fits."""
