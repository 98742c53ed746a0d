"""What the setup of Lu et al. 2008 does not report: calibration of its maps, and what each assumption changes."""
