"""Three-tracker recordings: readers, resampling, calibration, simulation from takes."""
