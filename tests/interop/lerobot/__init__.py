"""LeRobot's side of the datasets: `./dev interop lerobot`."""
