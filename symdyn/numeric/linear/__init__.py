"""Linear models at an operating point: responses, modes, sensitivities, reduction; arrays in, records out."""
