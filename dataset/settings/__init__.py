"""Settings from presets, YAML files and the command line."""
