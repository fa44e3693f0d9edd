"""How a file's numbers are to be understood: columns by their names, axes and units by what a person can do."""
