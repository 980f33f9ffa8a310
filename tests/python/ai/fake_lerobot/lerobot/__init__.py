"""As much of LeRobot as the child process uses: it gives what a checkpoint's `config.json` asks for."""
