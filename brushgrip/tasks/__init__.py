"""What the commands do, one file each; imported only when a command runs, so that help is quick."""
