"""Other people's learning code on the four environments, as `gymnasium.make` gives them: `./dev interop rl`."""
