"""Three-tracker recordings: readers, repair, resampling, calibration, simulation from takes."""
